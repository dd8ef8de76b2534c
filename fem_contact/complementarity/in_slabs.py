"""The contact iteration on grids in slabs: the response, the passes, and what is carried between grids."""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.fft

from fem_contact._types import AnyArray, Array, Lengths, Numbers, Shape
from fem_contact.complementarity.fourier import FourierOperator, carried, refined_along
from fem_contact.complementarity.grids import Grids
from fem_contact.complementarity.iteration_arrays import Errors, IterationArrays, _levels
from fem_contact.complementarity.rows import Rows
from fem_contact.complementarity.slabs import SlabNumpy, Slabs, shares
from fem_contact.response import Response


class SlabOperator(FourierOperator):
    """The response of a solid on one grid in slabs; see `FourierOperator`."""

    def __init__(self, response: Response, slabs: Slabs, lengths: Lengths, *, threads: int) -> None:
        self.slabs, self.shape, self.threads = slabs, slabs.shape, threads
        columns = slice(*slabs.columns[slabs.rank : slabs.rank + 2])
        self._evaluate(response, lengths, columns=columns, gathered=slabs.gathered)
        self._with_mean = columns.start == 0
        self._rows = Rows(slabs.shape[0], threads=threads)
        self._spectrum = np.empty(self.compliance.shape, dtype=complex)

    def _filter(self, field: AnyArray, out: AnyArray, *, inverse: bool = False, weaken: bool = False) -> None:
        import ducc0.fft

        from fem_contact.complementarity.kernels import divide, multiply

        spectrum = self._room_for(field)
        slabs, threads, waves = self.slabs, self.threads, self.shape[1] // 2 + 1

        def lines(lo: int, hi: int) -> AnyArray:
            along = np.empty((hi - lo, waves), dtype=spectrum.dtype)
            ducc0.fft.r2c(field[lo:hi], axes=(1,), out=along, nthreads=threads)
            return along

        slabs.to_columns(lines, slabs.columns, spectrum)
        ducc0.fft.c2c(spectrum, axes=(0,), out=spectrum, nthreads=threads)
        first = spectrum[0, 0]
        self._rows.run(divide if inverse else multiply, spectrum, self.compliance)
        if inverse and not self._with_mean:
            # The kernel takes the first number for the mean.
            spectrum[0, 0] = first / self.compliance[0, 0]
        self._weaken(spectrum, weaken)
        ducc0.fft.c2c(spectrum, axes=(0,), forward=False, inorm=2, out=spectrum, nthreads=threads)
        slabs.to_rows(spectrum, slabs.columns, lambda lo, hi, part: self._along_rows(part, out[lo:hi]))


class _SlabRows(Rows):
    """Passes over the rows of a slab, whose sums are those of all slabs."""

    def __init__(self, slabs: Slabs, *, threads: int) -> None:
        super().__init__(slabs.last - slabs.first, threads=threads)
        self._slabs = slabs

    def add(self, kernel: Callable[..., Any], *arguments: object) -> list[float]:
        """Add up a kernel's results over all blocks of all slabs."""
        parts = self._slabs.gathered(*super().add(kernel, *arguments))
        return [float(total) for total in parts.sum(axis=0)]


class SlabIterationArrays(IterationArrays):
    """The arrays of one slab and the compiled passes over them; see `IterationArrays`.

    Levels of the extension have rows of the neighbouring slabs behind their own. As the coarser level of two,
    r rows are followed by the one after and the one before, where a period of r + 2 rows looks for them; as
    the finer one, its 2 r rows by the one after and, third from that, the one before.
    """

    def __init__(self, operator: SlabOperator, heights: Array, *, threads: int, **options: Any) -> None:
        super().__init__(operator, heights, threads=threads, **options)
        slabs = self.slabs = operator.slabs
        self.xp = SlabNumpy(slabs)
        self.count = slabs.shape[0] * slabs.shape[1]
        self.rows = _SlabRows(slabs, threads=threads)
        rows, ny = heights.shape
        precision = self.gap.dtype
        self._buffer, self._working = _padded(rows, ny, precision), _padded(rows, ny, np.bool_)
        self.buffer, self.working = self._buffer[:rows], self._working[:rows]
        self._sums, self._counts = [], []
        for _ in range(slabs.depth):
            rows, ny = -(-rows // 2), -(-ny // 2)
            self._sums.append(_padded(rows, ny, precision))
            self._counts.append(_padded(rows, ny, np.uint8))
        self.levels = [level[:-5] for level in self._sums], [level[:-5] for level in self._counts]
        self.top = _levels(-(-slabs.shape[0] // 2**slabs.depth), ny, self.gap.dtype.type)

    def move(self, factor: float, shift: float) -> Errors:
        """Move the gap, and measure the conditions there."""
        mine = vars(super().move(factor, shift)).values()
        return Errors.joined(self.slabs.gathered(*mine).tolist())

    def _restore(self, toward: float) -> None:
        super()._restore(toward)
        parts = self.slabs.gathered(self.slope, self.most)
        self.slope, self.most = float(parts[:, 0].sum()), float(parts[:, 1].max())

    def _whole(self, level: AnyArray) -> AnyArray:
        return self.slabs.whole(level)

    def _take_top(self) -> None:
        first, own = self.slabs.first >> self.slabs.depth, self.levels[0][-1]
        own[...] = self.top[0][0][first : first + len(own)]

    def _as_coarse(self, level: int) -> AnyArray:
        own, rows = self._sums[level], len(self.levels[0][level])
        own[rows + 1], own[rows] = self.slabs.exchanged(own[0], own[rows - 1])
        return own[: rows + 2]

    def _as_fine(self, level: int) -> tuple[AnyArray, AnyArray, AnyArray]:
        """Add rows of the neighbours; nothing comes from occupied cells, nor from a row that is alone."""
        own = self._buffer if level < 0 else self._sums[level]
        occupied = self._working.view(np.uint8) if level < 0 else self._counts[level]
        coarse, rows = self._sums[level + 1], len(own) - 5
        even = rows + rows % 2
        ends = [np.where(occupied[row], own.dtype.type(0), own[row]) for row in (0, rows - 1)]
        own[rows:] = 0
        own[even + 3], own[even] = self.slabs.exchanged(ends[0], ends[1] * (1 - rows % 2))
        count = len(coarse) - 5
        return own[: 2 * count + 4], occupied[: 2 * count + 4], coarse[: count + 2]


def _padded(rows: int, columns: int, dtype: Any) -> AnyArray:
    out = np.empty((rows + 5, columns), dtype=dtype)
    out[rows:] = 0
    return out


class SlabGrids(Grids):
    """Fields carried between grids in slabs; grids much smaller than a slab every process has as a whole."""

    in_slabs = True

    def __init__(self, slabs: Slabs, *, threads: int) -> None:
        super().__init__(slabs.shape, threads=threads)
        self.slabs, self.xp = slabs, SlabNumpy(slabs)

    def slabs_of(self, shape: Shape) -> Slabs | None:
        """Return the slabs of a grid; None where it is so small that every process has the whole."""
        finest = self.slabs
        if shape == finest.shape:
            return finest
        few = 4 * finest.size * shape[0] * shape[1] <= finest.shape[0] * finest.shape[1]
        if few or finest.size > min(shape[0] // 2, shape[1] // 2 + 1):
            return None
        return Slabs(finest.comm, shape)

    def operator_of(
        self, response: Response, shape: Shape, lengths: Lengths
    ) -> FourierOperator | SlabOperator:
        """Return the response of a solid on a grid with these sides [m], in slabs where it has some."""
        slabs = self.slabs_of(shape)
        if slabs is None:
            return FourierOperator(response, shape, lengths, threads=self.threads)
        return SlabOperator(response, slabs, lengths, threads=self.threads)

    def put(self, field: Any) -> Any:
        """Return the rows of this process; what has but those is taken for them."""
        whole = field is not None and field.shape == self.shape
        return field[self.slabs.first : self.slabs.last] if whole else field

    def residual_sums(self, pressure: Any, gap: Any, at_bound: Any) -> list[float]:
        """Return what the residuals of the whole are made of."""
        parts = self.slabs.gathered(*super().residual_sums(pressure, gap, at_bound))
        return [*parts[:, :3].sum(axis=0).tolist(), *parts[:, 3:].min(axis=0).tolist()]

    def coarsened(self, heights: Any, old: Shape, new: Shape) -> Any:
        """Return heights on a coarser grid, freed of the waves that it cannot carry."""
        import ducc0.fft

        source, target = self.slabs_of(old), self.slabs_of(new)
        if source is None:
            return super().coarsened(heights, old, new)
        waves, kept = new[1] // 2 + 1, (min(old[1], new[1]) - 1) // 2 + 1
        columns = shares(waves, source.size)

        def lines(lo: int, hi: int) -> AnyArray:
            along = np.zeros((hi - lo, waves), dtype=complex)
            along[:, :kept] = scipy.fft.rfft(heights[lo:hi], norm="forward", workers=self.threads)[:, :kept]
            return along

        spectrum = np.empty((old[0], columns[source.rank + 1] - columns[source.rank]), dtype=complex)
        source.to_columns(lines, columns, spectrum)
        rows = carried(old[0], new[0])
        coarse = np.zeros((new[0], spectrum.shape[1]), dtype=complex)
        coarse[rows % new[0]] = scipy.fft.fft(spectrum, axis=0, norm="forward", overwrite_x=True)[rows]
        coarse = scipy.fft.ifft(coarse, axis=0, norm="forward", overwrite_x=True)
        if target is None:
            lines_here = np.concatenate(source.comm.allgather(coarse), axis=1)
            return scipy.fft.irfft(lines_here, n=new[1], norm="forward")
        out = np.empty((target.last - target.first, new[1]))

        def put(lo: int, hi: int, part: AnyArray) -> None:
            ducc0.fft.c2r(part, axes=(1,), lastsize=new[1], forward=False, out=out[lo:hi])

        target.to_rows(coarse, columns, put)
        return out

    def refined(self, field: Any, old: Shape, new: Shape) -> Any:
        """Carry a field to a finer grid, bilinearly."""
        source, target = self.slabs_of(old), self.slabs_of(new)
        if target is None:
            return super().refined(field, old, new)

        def wanted(rank: int) -> Numbers:
            first, last = target.rows[rank : rank + 2]
            ends = first * old[0] // new[0], (last - 1) * old[0] // new[0]
            return np.arange(ends[0], ends[1] + 2) % old[0]

        rows = wanted(target.rank)
        block = field[rows] if source is None else source.taken(field, wanted)
        place = np.arange(target.first, target.last) * (old[0] / new[0])
        block = refined_along(block, 0, place - target.first * old[0] // new[0])
        return refined_along(block, 1, np.arange(new[1]) * (old[1] / new[1]))

    def nearest(self, field: Any, new: Shape) -> Any:
        """Take a field of the finest grid at the points of a coarser one, which may have no slabs."""
        old, target = self.shape, self.slabs_of(new)

        def wanted(rank: int) -> Numbers:
            first, last = (0, new[0]) if target is None else target.rows[rank : rank + 2]
            return np.arange(first, last) * old[0] // new[0]

        rows = self.slabs.taken(field, wanted)
        return super().nearest(rows, (rows.shape[0], new[1]))
