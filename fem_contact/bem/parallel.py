"""One boundary-element solve shared out over processes of MPI: its surface, its result, its file.

Each process has a slab of rows of every field. `solve(surface, ..., comm=comm)` presses a `SlabSurface`, or a
`HeightField` that every process has, and gives each process a `SlabResult`.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
import scipy.fft

from fem_contact._checks import instance
from fem_contact._types import AnyArray, Array, Lengths, Numbers, Shape
from fem_contact.complementarity.slabs import Slabs
from fem_contact.contact import ContactResult, HasContact
from fem_contact.errors import InvalidInput
from fem_contact.height_traits import HeightTraits, are_level, traits_of, wave_sums
from fem_contact.surface import HeightField, random_waves
from fem_contact.surface.random import checked_grid

if TYPE_CHECKING:
    from fem_contact.area import ContactAreas

#: Rows beyond a slab that the edges of contact in it are located with: those that their direction depends on.
_BEYOND = 8
#: Rows in which edges are located at once.
_BAND = 128

#: What is written of a result, and in which units.
_FIELDS = {
    "pressure": "Pa",
    "gap": "m",
    "displacement": "m",
    "heights": "m",
    "in_contact": "1",
    "at_bound": "1",
}


def communicator() -> Any:
    """Return the communicator of all processes, MPI.COMM_WORLD; there may be one.

    Raises
    ------
    InvalidInput
        Where MPI is not installed.
    """
    try:
        from mpi4py import MPI
    except (ImportError, RuntimeError) as error:
        reason = " ".join(str(error).split())[:80]
        raise InvalidInput(
            f"MPI: needs pip install 'fem-contact[mpi]' and an MPI library ({reason})"
        ) from None
    return MPI.COMM_WORLD


@dataclass(frozen=True, kw_only=True, eq=False)
class SlabSurface:
    """Heights of a periodic surface, of which each process has a slab of rows; see `HeightField`.

    Attributes
    ----------
    heights : (rows, ny) array
        Heights [m] of the rows of this process.
    lengths : tuple of float
        Periods (Lx, Ly) [m].
    rms_height, rms_gradient : float
        h_rms [m] and h'_rms [-] of the whole surface.
    """

    heights: Array
    lengths: Lengths
    slabs: Slabs
    rms_height: float
    rms_gradient: float

    @classmethod
    def of(cls, surface: HeightField, comm: Any) -> Self:
        """Take the slabs of a surface that every process has."""
        instance("surface", surface, HeightField, what="a `HeightField` or a `SlabSurface`")
        slabs = Slabs(comm, surface.shape)
        return cls(
            heights=surface.heights[slabs.first : slabs.last],
            lengths=surface.lengths,
            slabs=slabs,
            rms_height=surface.rms_height,
            rms_gradient=surface.rms_gradient,
        )

    @classmethod
    def random(
        cls,
        spectrum: Callable[..., Array],
        *,
        q_short: float,
        lengths: Lengths,
        shape: Shape,
        seed: int | np.random.Generator,
        amplitudes: Literal["exact", "gaussian"] = "exact",
        isotropic: bool = True,
        comm: Any,
    ) -> Self:
        """Make a random surface in slabs, the same as `random_surface` makes; no process has the whole."""
        slabs = Slabs(comm, shape)
        checked_grid(shape, lengths, q_short, False)
        first, last = slabs.columns[slabs.rank : slabs.rank + 2]
        waves = random_waves(
            spectrum,
            q_short=q_short,
            lengths=lengths,
            seed=seed,
            amplitudes=amplitudes,
            isotropic=isotropic,
            columns=(first, last),
        )
        half = np.zeros((shape[0], last - first), dtype=complex)
        # Waves along x stand for both signs here, too.
        half[waves.m % shape[0], waves.n - first] = np.where(waves.n == 0, 2, 1) * waves.amplitudes
        power = np.abs(half) ** 2 * np.where(np.arange(first, last) == 0, 0.5, 2.0)
        qx = 2 * np.pi * scipy.fft.fftfreq(shape[0], lengths[0] / shape[0])
        qy = 2 * np.pi / lengths[1] * np.arange(first, last)
        m2 = power.sum(axis=1) @ qx**2 + power.sum(axis=0) @ qy**2
        m0, m2 = slabs.gathered(float(power.sum()), float(m2)).sum(axis=0)
        del power
        half = scipy.fft.ifft(half, axis=0, norm="forward", overwrite_x=True)
        heights = np.empty((slabs.last - slabs.first, shape[1]))

        def put(lo: int, hi: int, lines: AnyArray) -> None:
            heights[lo:hi] = scipy.fft.irfft(lines, n=shape[1], norm="forward")

        slabs.to_rows(half, slabs.columns, put)
        return cls(
            heights=heights,
            lengths=lengths,
            slabs=slabs,
            rms_height=math.sqrt(m0),
            rms_gradient=math.sqrt(m2),
        )

    @property
    def shape(self) -> Shape:
        """Number of grid points (nx, ny) of the whole surface."""
        return self.slabs.shape

    @property
    def spacing(self) -> Lengths:
        """Grid spacing (dx, dy) [m]."""
        return self.lengths[0] / self.shape[0], self.lengths[1] / self.shape[1]


@dataclass(frozen=True, kw_only=True, eq=False)
class SlabResult(HasContact):
    """Solution of one contact problem, of which each process has a slab of rows.

    Attributes
    ----------
    contact : ContactResult
        Fields of the rows of this process; all numbers are those of the whole.
    """

    contact: ContactResult
    slabs: Slabs

    def whole(self) -> ContactResult:
        """Return the result with all rows, on every process."""
        contact, (nx, _) = self.contact, self.slabs.shape
        fields: dict[str, Any] = {name: self.slabs.whole(getattr(contact, name)) for name in _FIELDS}
        lengths = contact.spacing[0] * nx, contact.lengths[1]
        return replace(contact, **fields, lengths=lengths)

    def areas(self, *, subcell: bool = True) -> ContactAreas:
        """Contact area in several definitions, as `contact_areas` gives it of a whole result."""
        from fem_contact.area import EDGE_CONSTANTS, EDGE_MAPS, ContactAreas, alignment, contact_edges

        contact, (nx, ny), slabs = self.contact, self.slabs.shape, self.slabs
        dx, dy = contact.spacing
        if subcell and abs(dx / dy - 1) > 0.05:
            raise InvalidInput(f"cells of {dx:.6g} m x {dy:.6g} m: the edge is located on square cells only")

        names = ("pressure", "gap", "in_contact")
        unused: dict[str, Any] = dict.fromkeys(("at_bound", "heights", "displacement"), np.empty((0, ny)))
        map_ = np.array(EDGE_MAPS["bem"])

        def wanted(rank: int) -> Numbers:
            first, last = slabs.rows[rank : rank + 2]
            return np.append(np.arange(first - _BEYOND, first), np.arange(last, last + _BEYOND)) % nx

        ends = {name: np.split(slabs.taken(getattr(contact, name), wanted), 2) for name in names}
        total, rows = np.zeros(6), slabs.last - slabs.first
        for first in range(0, rows, _BAND):
            last = min(first + _BAND, rows)
            fields: dict[str, Any] = {}
            for name in names:
                inner = getattr(contact, name)[max(first - _BEYOND, 0) : last + _BEYOND]
                below, above = ends[name][0][first:], ends[name][1][: max(last + _BEYOND - rows, 0)]
                fields[name] = np.concatenate([below, inner, above])
            count = len(fields["gap"])
            band = replace(contact, **fields, **unused, lengths=(dx * count, contact.lengths[1]))
            touching = band.in_contact[_BEYOND:-_BEYOND]
            total[:3] += (
                np.sum(touching),
                np.sum(touching != band.in_contact[_BEYOND - 1 : -_BEYOND - 1]),
                np.sum(touching != np.roll(touching, 1, axis=1)),
            )
            edges = contact_edges(band)
            row = edges.inside // ny
            here = (row >= _BEYOND) & (row < count - _BEYOND)
            edges = replace(edges, **{name: values[here] for name, values in vars(edges).items()})
            total[3:] += edges.shift(map_), *edges.harmonics()
        sums = slabs.gathered(*total).sum(axis=0) / (nx * ny)
        pixel, fraction = float(sums[0]), float(sums[1] + sums[2])
        return ContactAreas(
            pixel=pixel,
            perimeter=pixel - EDGE_CONSTANTS["bem"] * fraction,
            edge_length=float(sums[1] / dx + sums[2] / dy),
            edge_fraction=fraction,
            edge_constant=EDGE_CONSTANTS["bem"],
            spacing=(dx, dy),
            subcell=float(sums[0] + sums[3]) if subcell else None,
            cells=nx * ny,
            alignment=alignment(sums[4:]),
            **vars(self._height_traits()),
        )

    def _height_traits(self) -> HeightTraits:
        """Find what the heights of all slabs are like."""
        slabs, heights = self.slabs, self.contact.heights
        mean = slabs.gathered(float(np.sum(heights))).sum() / (slabs.shape[0] * slabs.shape[1])
        extremes = float(np.max(np.abs(heights - mean))), float(np.max(np.abs(heights)))
        largest, height = slabs.gathered(*extremes).max(axis=0)
        if are_level(largest, height):
            return HeightTraits()
        first, last = slabs.columns[slabs.rank : slabs.rank + 2]
        waves = np.empty((slabs.shape[0], last - first), dtype=complex)
        slabs.to_columns(
            lambda lo, hi: scipy.fft.rfft((heights[lo:hi] - mean) / largest), slabs.columns, waves
        )
        waves = scipy.fft.fft(waves, axis=0, overwrite_x=True)
        sums = wave_sums(waves, slabs.shape, self.contact.spacing, first)
        return traits_of(slabs.gathered(*sums).sum(axis=0))

    def write(self, path: Path, *, about: Mapping[str, Any]) -> None:
        """Write all fields into one file of HDF5, which netCDF reads, too; each process its own rows at once.

        The first process lays the file out, and each writes its rows at their place in it, so that HDF5
        itself need not know of MPI. The file has its name only when it is complete; it lies on a disk that
        all processes share. `about` are its attributes.
        """
        draft = path.with_name(f".{path.name}.part")
        places: dict[str, int] = {}
        problem = ""
        if self.slabs.rank == 0:
            try:
                places = self._laid_out(draft, about)
            except OSError as error:
                problem = str(error)
        places, problem = self.slabs.comm.bcast((places, problem))
        if problem:
            raise InvalidInput(f"{path}: cannot be written ({problem})")
        with draft.open("r+b") as file:
            for name, place in places.items():
                field = np.ascontiguousarray(getattr(self.contact, name))
                field = field.view(np.int8) if field.dtype == np.bool_ else field
                file.seek(place + self.slabs.first * field[:1].nbytes)
                file.write(field.data)
            file.flush()
            os.fsync(file.fileno())
        self.slabs.gathered(0.0)
        if self.slabs.rank == 0:
            draft.replace(path)

    def _laid_out(self, path: Path, about: Mapping[str, Any]) -> dict[str, int]:
        """Make the file without its fields; the place [bytes] of each."""
        import h5py

        places = {}
        with h5py.File(path, "w", track_order=True) as file:
            file.attrs.update(about)
            for axis, count, step in zip("xy", self.slabs.shape, self.contact.spacing, strict=True):
                file[axis] = np.arange(count) * step
                file[axis].attrs["units"] = "m"
                file[axis].make_scale(axis)
            for name, unit in _FIELDS.items():
                layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
                layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
                layout.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
                kind = h5py.h5t.py_create(np.dtype("i1" if unit == "1" else "f8"))
                space = h5py.h5s.create_simple(self.slabs.shape)
                data = h5py.Dataset(h5py.h5d.create(file.id, name.encode(), kind, space, layout))
                data.attrs["units"] = unit
                for axis, dimension in zip("xy", data.dims, strict=True):
                    dimension.attach_scale(file[axis])
                places[name] = data.id.get_offset()
        return places
