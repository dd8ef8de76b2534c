"""Displacement inside the block, layer by layer from the surface down, and the stress read off it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fem_contact.block.column import eliminate, split_layer
from fem_contact.block.elements import Element
from fem_contact.block.reduced import BlockResponse, phase_pairs
from fem_contact.errors import InsufficientMemory

__all__ = ["ArraySource", "CellLayer", "FieldSource", "FourierSource"]

Array = NDArray[np.float64]
Waves = NDArray[np.complex128]


@dataclass(frozen=True, kw_only=True)
class CellLayer:
    """Displacement of the nodes of one layer of cells.

    Attributes
    ----------
    index : int
        Number of the layer, from the bottom upwards.
    nodes : (order + 1, nx, ny, 3) array
        Displacement [m] of its planes of nodes, from the lower to the upper.
    pressure : (cells, cells) array or None
        Mean pressure unknown of each cell, tension positive, over the layer's Young's modulus, where the
        element carries it.
    """

    index: int
    nodes: Array
    pressure: Array | None = None

    def gradient(self, size: tuple[float, float, float], element: Element) -> Array:
        """Differentiate u_a along x_b [-] at the centres of cells of a size [m], (nx, ny, 3, 3)."""
        if element.order == 2:
            u, s = self.nodes, 2
            along_x = (np.roll(u, -2, axis=1) - u)[1, ::s, 1::s]
            along_y = (np.roll(u, -2, axis=2) - u)[1, 1::s, ::s]
            along_z = (u[2] - u[0])[1::s, 1::s]
        else:
            right, ahead = np.roll(self.nodes, -1, axis=1), np.roll(self.nodes, -1, axis=2)
            both = np.roll(right, -1, axis=2)
            along_x = 0.25 * (right + both - self.nodes - ahead).sum(axis=0)
            along_y = 0.25 * (ahead + both - self.nodes - right).sum(axis=0)
            mean = 0.25 * (self.nodes + right + ahead + both)
            along_z = mean[1] - mean[0]
        return np.stack([along_x / size[0], along_y / size[1], along_z / size[2]], axis=-1)

    def mean_dilatation(self, size: tuple[float, float, float], element: Element) -> Array:
        """Return the mean of div u over each cell [-], to which elements with pressures respond."""
        if element.order == 1:
            return np.asarray(np.trace(self.gradient(size, element), axis1=-2, axis2=-1))
        u = self.nodes
        in_z = (u[0] + 4 * u[1] + u[2]) / 6
        along_x = _simpson(np.roll(in_z[..., 0], -2, axis=0) - in_z[..., 0], axis=1)[::2] / size[0]
        along_y = _simpson(np.roll(in_z[..., 1], -2, axis=1) - in_z[..., 1], axis=0)[:, ::2] / size[1]
        rise = (u[2] - u[0])[..., 2] / size[2]
        return np.asarray(along_x + along_y + _simpson(_simpson(rise, axis=0), axis=1))


def _simpson(values: Array, *, axis: int) -> Array:
    """Mean over cells two nodes wide along one axis."""
    middle = np.roll(values, -1, axis=axis)
    mean = (values + 4 * middle + np.roll(values, -2, axis=axis)) / 6
    return mean[::2] if axis == 0 else mean[:, ::2]


class FieldSource(Protocol):
    """Whatever can walk down through the block."""

    def descend(self) -> Iterator[CellLayer]:
        """Yield the layers from the surface down."""
        ...


@dataclass(frozen=True, kw_only=True)
class ArraySource:
    """A field that is held in memory.

    Attributes
    ----------
    field : (nx, ny, planes, 3) array
        Displacement [m], from the clamped plane upwards.
    order : int
    """

    field: Array
    order: int = 1

    def descend(self) -> Iterator[CellLayer]:
        """Yield the layers from the surface down."""
        for top in range(self.field.shape[2] - 1, 0, -self.order):
            planes = self.field[:, :, top - self.order : top + 1]
            yield CellLayer(index=top // self.order - 1, nodes=np.moveaxis(planes, 2, 0))


@dataclass(frozen=True, kw_only=True)
class FourierSource:
    """The field under given nodal forces: one Fourier solve, of which only a layer is held at a time.

    Attributes
    ----------
    response : BlockResponse
    force : (nx, ny) array
        Downward nodal force over E times the cell width squared.
    width : float
        Width of a cell [m].
    threads : int
    """

    response: BlockResponse
    force: Array
    width: float
    threads: int = 1

    def descend(self) -> Iterator[CellLayer]:
        """Yield the layers from the surface down."""
        if self.response.mesh.element.order == 1:
            yield from self._descend_trilinear()
        else:
            yield from self._descend_any()

    def _descend_trilinear(self) -> Iterator[CellLayer]:
        from fem_contact.block.kernels import descend, pack

        mesh = self.response.mesh
        nx, ny = mesh.shape
        x, y = 2 * np.pi * np.arange(nx // 2 + 1) / nx, 2 * np.pi * scipy.fft.rfftfreq(ny)
        phases = phase_pairs(x, y)
        packed, parity = pack(self.response.folded.coefficients)
        states = np.empty((mesh.nz - 1, len(phases), 6))
        surface = self.response.surface_amplitudes(phases, states=states)
        mirrored = np.arange(nx) > nx // 2
        row = np.where(mirrored, nx - np.arange(nx), np.arange(nx))
        number = row[:, None] * y.size + np.arange(y.size)
        # A force upwards of amplitude f is i times -i f, and so is u_z.
        load = 1j * scipy.fft.rfft2(self.force, workers=self.threads)
        waves = surface[number] * load[:, :, None]
        waves[mirrored, :, 0] *= -1
        quadrant = np.where(mirrored[:, None], -1 - number, number)
        upper = self._plane(waves)
        for layer in range(mesh.nz - 1, -1, -1):
            lower = np.zeros_like(upper)
            if layer > 0:
                descend(packed[layer], parity, phases, states[layer - 1], quadrant, waves)
                lower = self._plane(waves)
            yield CellLayer(index=layer, nodes=np.stack([lower, upper]))
            upper = lower

    def _plane(self, waves: Waves) -> Array:
        nx, ny = self.response.mesh.cells
        plane = np.empty((nx, ny, 3))
        for a in range(3):
            wave = 1j * waves[:, :, a] if a == 2 else waves[:, :, a]
            plane[:, :, a] = scipy.fft.irfft2(wave, s=(nx, ny), workers=self.threads)
        return plane * self.width

    def _descend_any(self) -> Iterator[CellLayer]:
        folded, mesh = self.response.folded, self.response.mesh
        (nx, ny), plane, inner, modes = mesh.cells, folded.plane, folded.inner, folded.pressures
        x, y = 2 * np.pi * scipy.fft.fftfreq(nx), 2 * np.pi * scipy.fft.rfftfreq(ny)
        phases = phase_pairs(x, y)
        turns = np.stack(
            [np.exp(0.5j * (x[:, None] * a + y * b)).ravel() for a in (0, 1) for b in (0, 1)], axis=1
        )
        _refuse_beyond_memory(len(phases), plane + modes, mesh.nz)
        states = eliminate(folded, phases, keep=True)
        loads = np.zeros((len(phases), states.top.shape[1]), dtype=complex)
        for kind, lattice in enumerate(
            (slice(a, None, 2), slice(b, None, 2)) for a in (0, 1) for b in (0, 1)
        ):
            wave = scipy.fft.rfft2(self.force[lattice], workers=self.threads).ravel()
            loads[:, 3 * kind + 2] = 1j * wave / turns[:, kind]
        waves: Waves = np.linalg.solve(states.top, loads[:, :, None])[:, :, 0].astype(complex)
        upper = self._lattices(waves[:, :plane], turns)
        for layer in range(mesh.nz - 1, -1, -1):
            state = states.below[layer - 1] if layer > 0 else None
            parts = split_layer(
                folded.matrices(layer, phases), state, plane=plane, inner=inner, pressures=modes
            )
            answer: Waves = -np.linalg.solve(parts[0], parts[1] @ waves[:, :, None])[:, :, 0].astype(complex)
            pressure = None
            if modes:
                centre = np.exp(0.5j * (x[:, None] + y)).ravel()
                pressure = scipy.fft.irfft2((1j * waves[:, plane] * centre).reshape(nx, -1), s=(nx, ny))
            middle = self._lattices(answer[:, -inner:], turns)
            waves = answer[:, : plane + modes]
            lower = np.zeros_like(upper) if state is None else self._lattices(waves[:, :plane], turns)
            yield CellLayer(index=layer, nodes=np.stack([lower, middle, upper]), pressure=pressure)
            upper = lower

    def _lattices(self, waves: Waves, turns: Waves) -> Array:
        nx, ny = self.response.mesh.cells
        plane = np.empty((2 * nx, 2 * ny, 3))
        for kind, (a, b) in enumerate((a, b) for a in (0, 1) for b in (0, 1)):
            turned = waves[:, 3 * kind : 3 * kind + 3] * turns[:, kind, None] * np.array([1, 1, 1j])
            turned = turned.reshape(nx, -1, 3)
            plane[a::2, b::2] = scipy.fft.irfft2(turned, s=(nx, ny), axes=(0, 1), workers=self.threads)
        return plane * self.width


def _refuse_beyond_memory(waves: int, state: int, layers: int) -> None:
    import psutil

    # The states at all boundaries, and a few work matrices of one layer.
    needed, available = (
        8 * waves * (state**2 * layers + 20 * state**2),
        int(psutil.virtual_memory().available),
    )
    if needed > available:
        raise InsufficientMemory(
            f"the field of triquadratic cells needs {needed / 2**30:.3g} GiB on the way, "
            f"{available / 2**30:.2g} GiB are available: take a coarser grid or trilinear cells"
        )
