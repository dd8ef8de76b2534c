"""One grid in slabs of rows, one per process of MPI: what the processes tell each other, and no more.

Of a process are the rows `Slabs.first` to `Slabs.last` of each field and a few columns of each spectrum. A
transform is along rows, a transposition of all with all, and along columns. Sums are gathered and added in
the order of the processes: all get the same bits, by which all take the same branches. Grids much smaller
than a slab every process solves whole.

Nothing here imports MPI: a communicator is anything with `rank`, `size` and six calls of mpi4py.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from fem_contact._types import AnyArray, Array, Numbers, Shape
from fem_contact.errors import InvalidInput
from fem_contact.settings import Settings

#: Bytes of the rows that are transposed at once, and the number of turns that this is done in at most.
_TURN, _TURNS = 2**21, 16


class Slabs:
    """How the rows of a grid, and the columns of its spectra, are shared out over processes.

    Of the points (nx, ny) of a grid P processes can share, nx must be 2 P and ny 2 P - 2 at least: a smaller
    one is refused.
    """

    def __init__(self, comm: Any, shape: Shape) -> None:
        self.comm, self.shape, self.rank, self.size = comm, shape, int(comm.rank), int(comm.size)
        nx, waves = shape[0], shape[1] // 2 + 1
        most = min(nx // 2, waves)
        if self.size > most:
            raise InvalidInput(
                f"{self.size} processes: a grid of {nx} x {shape[1]} points can be shared by {most} at most"
            )
        # Slabs are whole cells of this level of the extension, of which all processes then hold all.
        wanted = (8 * self.size - 1).bit_length() // 2 + 1
        self.depth = min(wanted, (nx // self.size).bit_length() - 1)
        cell = 2**self.depth
        self.rows = [min(nx, cell * edge) for edge in shares(-(-nx // cell), self.size)]
        self.columns = shares(waves, self.size)
        self.first, self.last = self.rows[self.rank : self.rank + 2]

    def gathered(self, *values: Any) -> Array:
        """Return the numbers of all processes, one row each."""
        parts = np.empty((self.size, len(values)))
        self.comm.Allgather(np.array(values, dtype=float), parts)
        return parts

    def exchanged(self, first: AnyArray, last: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Exchange rows at the ends with the neighbouring slabs, periodically.

        Sends `first` to the slab before and `last` to the one after; returns the last row of the slab
        before and the first of the one after.
        """
        first, last = np.ascontiguousarray(first), np.ascontiguousarray(last)
        before, after = np.empty_like(last), np.empty_like(first)
        below, above = (self.rank - 1) % self.size, (self.rank + 1) % self.size
        self.comm.Sendrecv(last, dest=above, recvbuf=before, source=below)
        self.comm.Sendrecv(first, dest=below, recvbuf=after, source=above)
        return before, after

    def taken(self, field: AnyArray, wanted: Callable[[int], Numbers]) -> AnyArray:
        """Return the rows of a field, whichever slabs they are in, that `wanted` lists for this process."""
        requests = [wanted(rank) for rank in range(self.size)]
        given = [rows[(rows >= self.first) & (rows < self.last)] - self.first for rows in requests]
        owner = np.searchsorted(self.rows, requests[self.rank], side="right") - 1
        received = np.empty((owner.size, *field.shape[1:]), dtype=field.dtype)
        width = field[:1].size
        sent = np.ascontiguousarray(field[np.concatenate(given)])
        counts = [int(np.count_nonzero(owner == rank)) * width for rank in range(self.size)]
        self.comm.Alltoallv(
            [sent, _placed([rows.size * width for rows in given])], [received, _placed(counts)]
        )
        out = np.empty_like(received)
        out[np.argsort(owner, kind="stable")] = received
        return out

    def whole(self, field: AnyArray) -> AnyArray:
        """Return a field that is held in slabs as a whole, to every process."""
        counts = self.comm.allgather(field.shape[0])
        out = np.empty((sum(counts), *field.shape[1:]), dtype=field.dtype)
        width = field[:1].size
        self.comm.Allgatherv(np.ascontiguousarray(field), [out, _placed([n * width for n in counts])])
        return out

    def to_columns(self, lines: Callable[[int, int], AnyArray], columns: list[int], out: AnyArray) -> None:
        """Transpose half spectra of rows, made by ``lines(lo, hi)``, into this process's columns."""
        mine = out.shape[1]
        for spans in self._turns(out.itemsize):
            lines_here = lines(*spans[self.rank])
            counts = [len(lines_here) * (b - a) for a, b in pairwise(columns)]
            sent = np.empty(sum(counts), dtype=out.dtype)
            for part, (a, b) in zip(_split(sent, counts), pairwise(columns), strict=True):
                part.reshape(len(lines_here), b - a)[...] = lines_here[:, a:b]
            received = [(hi - lo) * mine for lo, hi in spans]
            places = [(row + lo) * mine for row, (lo, _) in zip(self.rows, spans, strict=False)]
            self.comm.Alltoallv([sent, _placed(counts)], [out, (received, places)])

    def to_rows(
        self, spectrum: AnyArray, columns: list[int], put: Callable[[int, int, AnyArray], None]
    ) -> None:
        """Transpose back, and hand the half spectra of rows to ``put(lo, hi, lines)``."""
        mine = spectrum.shape[1]
        for spans in self._turns(spectrum.itemsize):
            lo, hi = spans[self.rank]
            counts = [(b - a) * (hi - lo) for a, b in pairwise(columns)]
            sent = [(end - begin) * mine for begin, end in spans]
            places = [(row + begin) * mine for row, (begin, _) in zip(self.rows, spans, strict=False)]
            received = np.empty(sum(counts), dtype=spectrum.dtype)
            self.comm.Alltoallv([spectrum, (sent, places)], [received, _placed(counts)])
            # Rows a power of two apart compete for the same lines of the cache.
            lines = np.empty((hi - lo, columns[-1] + 7), dtype=spectrum.dtype)[:, : columns[-1]]
            for part, (a, b) in zip(_split(received, counts), pairwise(columns), strict=True):
                lines[:, a:b] = part.reshape(hi - lo, b - a)
            put(lo, hi, lines)

    def _turns(self, itemsize: int) -> list[list[tuple[int, int]]]:
        """Spans of the rows of every slab that are transposed at once, turn by turn."""
        counts = [last - first for first, last in pairwise(self.rows)]
        turns = max(1, min(_TURNS, max(counts) * (self.shape[1] // 2 + 1) * itemsize // _TURN))
        return [[(n * k // turns, n * (k + 1) // turns) for n in counts] for k in range(turns)]


def shares(count: int, processes: int) -> list[int]:
    """Edges of even shares of a number of things."""
    return [count * k // processes for k in range(processes + 1)]


def _placed(counts: list[int]) -> tuple[list[int], list[int]]:
    """Return counts, and the places of parts that lie one after the other."""
    return counts, [0, *np.cumsum(counts[:-1]).tolist()] if counts[:-1] else [0]


def _split(flat: AnyArray, counts: list[int]) -> list[AnyArray]:
    return np.split(flat, np.cumsum(counts)[:-1])


class SlabNumpy:
    """NumPy, but for sums, means and extremes, which are those of the whole grid."""

    def __init__(self, slabs: Slabs) -> None:
        self._slabs = slabs

    def __getattr__(self, name: str) -> Any:
        function = getattr(np, name)
        if name not in ("sum", "min", "max"):
            return function
        return lambda values: float(function(self._slabs.gathered(float(function(values)))))

    def mean(self, values: AnyArray) -> float:
        """Mean over all slabs."""
        total: float = self.sum(values)
        return total / (self._slabs.shape[0] * self._slabs.shape[1])

    def any(self, values: AnyArray) -> bool:
        """Whether it holds anywhere."""
        return bool(self.max(values) > 0)


@dataclass(frozen=True, kw_only=True)
class SlabSettings(Settings):
    """Settings by which all processes stop at once: the clock is that of the first."""

    comm: Any = None

    def expired(self, began: float) -> bool:
        """Whether the time allowed has passed."""
        return self.time_limit is not None and bool(self.comm.bcast(super().expired(began)))
