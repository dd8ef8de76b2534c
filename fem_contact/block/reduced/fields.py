"""Displacement inside the reduced block, layer by layer from the surface down."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.fft

from fem_contact._checks import room_for
from fem_contact._types import Array, Complex
from fem_contact.block.reduced.column import surface_compliance
from fem_contact.block.reduced.surface import BlockResponse, phase_pairs
from fem_contact.block.solution import CellLayer
from fem_contact.complementarity.rows import Rows


@dataclass(frozen=True, kw_only=True)
class FourierSource:
    """The field under given nodal forces: one Fourier solve, of which only a layer is held at a time."""

    response: BlockResponse
    force: Array  # (nx, ny): Downward nodal force over E times the cell width squared
    width: float  # Width of a cell [m]
    threads: int = 1

    def descend(self) -> Iterator[CellLayer]:
        """Yield the layers from the surface down: what lies below takes each wave one layer deeper.

        That is kept for one quadrant of wavevectors; -1 - number marks waves mirrored in x.
        """
        from fem_contact.block.reduced.kernels import descend

        folded, mesh = self.response.folded, self.response.mesh
        (nx, ny), order, plane = mesh.cells, mesh.element.order, folded.plane
        y = 2 * np.pi * scipy.fft.rfftfreq(ny)
        phases = phase_pairs(2 * np.pi * np.arange(nx // 2 + 1) / nx, y)
        size = plane + folded.pressures
        upper = np.triu_indices(size)
        needed = 8.0 * mesh.nz * len(phases) * upper[0].size
        if order == 2:
            remedy = "take a coarser grid or trilinear cells"
            room_for("the field of triquadratic cells", needed=needed, remedy=remedy)
        states = np.empty((mesh.nz, len(phases), upper[0].size))
        surface_compliance(folded, phases, states=states)
        i = np.arange(nx)
        number = np.minimum(i, nx - i)[:, None] * y.size + np.arange(y.size)
        quadrant = np.where(i[:, None] > nx // 2, -1 - number, number).ravel()
        # A mirror in x turns u_x, and the pressure mode that is odd in x.
        signs = np.ones(size)
        signs[:plane:3] = signs[plane + 1 : plane + 2] = -1
        # Nodes of each kind are a lattice of their own, half a cell from the others.
        x = 2 * np.pi * np.where(i > nx // 2, i - nx, i)[:, None] / nx
        kinds = list(np.ndindex(order, order))
        turns = np.stack([np.exp(0.5j * (x * a + y * b)).ravel() for a, b in kinds], axis=1)
        # A force upwards of amplitude f is i times -i f, and so is u_z.
        lattices = np.stack([self.force[a::order, b::order] for a, b in kinds])
        load = 1j * scipy.fft.rfft2(lattices, workers=self.threads).reshape(len(kinds), -1).T / turns
        top, unit = np.empty((len(phases), size, size)), np.zeros((size, folded.types))
        top[:, upper[0], upper[1]] = top[:, upper[1], upper[0]] = states[-1]
        unit[2:plane:3] = np.eye(folded.types)
        answer = np.linalg.solve(top, np.broadcast_to(unit, (len(phases), *unit.shape)))
        waves: Complex = np.einsum("wst,wt->ws", answer[number.ravel()], load)
        waves[quadrant < 0] *= signs
        entries, terms, weights, places, below, counts = folded.plan
        rows = Rows(-(-len(waves) // int(counts[-1])), threads=self.threads, least=8)
        above, middle = self._plane(waves, turns), np.empty((len(waves), folded.inner), dtype=complex)
        for layer in range(mesh.nz - 1, -1, -1):
            pressure = None
            if folded.pressures:
                centre = (1j * waves[:, plane]).reshape(nx, -1) * np.exp(0.5j * (x + y))
                pressure = scipy.fft.irfft2(centre, s=(nx, ny), workers=self.threads)
            state = states[layer - 1] if layer > 0 else np.empty((0, 0))
            options = places, below, counts, phases, state, quadrant, signs, waves, middle
            rows.run(descend, entries, terms, weights[layer], *options)
            lower = self._plane(waves, turns) if layer > 0 else np.zeros_like(above)
            inside = [self._plane(middle, turns)] if folded.inner else []
            yield CellLayer(index=layer, nodes=np.stack([lower, *inside, above]), pressure=pressure)
            above = lower

    def _plane(self, waves: Complex, turns: Complex) -> Array:
        """Displacement [m] of a plane of nodes."""
        (nx, ny), order = self.response.mesh.cells, self.response.mesh.element.order
        plane = np.empty((order * nx, order * ny, 3))
        for kind, (a, b) in enumerate(np.ndindex(order, order)):
            for component, turn in enumerate((1, 1, 1j)):
                wave = (waves[:, 3 * kind + component] * (turn * turns[:, kind])).reshape(nx, -1)
                moved = scipy.fft.irfft2(wave, s=(nx, ny), workers=self.threads)
                plane[a::order, b::order, component] = moved
        return plane * self.width
