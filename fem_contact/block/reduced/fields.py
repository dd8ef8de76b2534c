"""Displacement inside the reduced block, layer by layer from the surface down."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from fem_contact._checks import room_for
from fem_contact._types import Array
from fem_contact.block.reduced.column import eliminate, split_layer
from fem_contact.block.reduced.surface import BlockResponse, phase_pairs
from fem_contact.block.solution import CellLayer
from fem_contact.complementarity.rows import Rows

__all__ = ["FourierSource"]

Waves = NDArray[np.complex128]


@dataclass(frozen=True, kw_only=True)
class FourierSource:
    """The field under given nodal forces: one Fourier solve, of which only a layer is held at a time."""

    response: BlockResponse
    force: Array  # (nx, ny): Downward nodal force over E times the cell width squared
    width: float  # Width of a cell [m]
    threads: int = 1

    def descend(self) -> Iterator[CellLayer]:
        """Yield the layers from the surface down."""
        if self.response.mesh.element.order == 1:
            yield from self._descend_trilinear()
        else:
            yield from self._descend_any()

    def _descend_trilinear(self) -> Iterator[CellLayer]:
        """Layers from the surface down: the six transfer states of each wave take it one layer deeper.

        Waves are kept for one quadrant of wavevectors; -1 - number marks those mirrored in x.
        """
        from fem_contact.block.reduced.kernels import descend, pack

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
        upper, rows = self._plane(waves), Rows(nx, threads=self.threads, least=32)
        for layer in range(mesh.nz - 1, -1, -1):
            lower = np.zeros_like(upper)
            if layer > 0:
                rows.run(descend, packed[layer], parity, phases, states[layer - 1], quadrant, waves)
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
        # The states at all boundaries, and a few work matrices of one layer.
        needed = 8.0 * len(phases) * (plane + modes) ** 2 * (mesh.nz + 20)
        remedy = "take a coarser grid or trilinear cells"
        room_for("the field of triquadratic cells", needed=needed, remedy=remedy)
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
