"""The block at finite strain: what users call."""

import itertools
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Unpack

import numpy as np

from fem_contact._checks import instance, positive, positives, within
from fem_contact._types import Array, Mask
from fem_contact.block.full.multigrid import build_hierarchy
from fem_contact.block.hyperelastic.cells import Cells
from fem_contact.block.hyperelastic.newton import Press, State, descend
from fem_contact.block.hyperelastic.profile import Profile
from fem_contact.block.mesh import BlockMesh, MeshOptions
from fem_contact.block.session import planned_mesh
from fem_contact.block.solver import solve
from fem_contact.errors import InvalidInput, NotConverged
from fem_contact.solid import Solid
from fem_contact.surface import HeightField

#: Newton steps at most.
_STEPS = 25
#: Least part of the way from flat to the slope asked for that is taken at once.
_LEAST = 1 / 16


@dataclass(frozen=True, kw_only=True)
class FiniteStrain:
    """A contact of a neo-Hookean block.

    Attributes
    ----------
    press : Press
        The problem, in cell widths and Young's modulus.
    state : State
        Its solution.
    mean_pressure : float
        Load over the nominal area [Pa].
    """

    press: Press
    state: State
    surface: HeightField
    solid: Solid
    mean_pressure: float
    cpu_seconds: float

    @property
    def mesh(self) -> BlockMesh:
        """The undeformed mesh."""
        return self.press.cells.mesh

    @property
    def in_contact(self) -> Mask:
        """Nodes on the profile."""
        return self.state.nodes

    @property
    def shares(self) -> Array:
        """Area of each surface node where it is now, projected on the plane, over a cell: mean 1."""
        u, aspect = self.state.field[:, :, -1, :2], self.mesh.aspect
        right, ahead = np.roll(u, -1, axis=0), np.roll(u, -1, axis=1)
        # Half the cross product of the diagonals of each quadrilateral.
        first = np.roll(right, -1, axis=1) - u + (1, aspect)
        second = ahead - right + (-1, aspect)
        cell = 0.5 * (first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]) / aspect
        around = [np.roll(cell, move, axis=(0, 1)) for move in ((0, 0), (1, 0), (0, 1), (1, 1))]
        return np.asarray(np.mean(around, axis=0))

    @property
    def pressure(self) -> Array:
        """Normal pressure at the surface nodes [Pa]: vertical force over the projected area."""
        area = self.shares * self.mesh.aspect
        return self.solid.young * self.state.force / area

    @property
    def gap(self) -> Array:
        """Vertical distance of the profile from each surface node, where it is now [m]."""
        return self.press.gap(self.state) * self.width

    @property
    def width(self) -> float:
        """Width of a cell along x [m]."""
        return self.surface.spacing[0]

    @property
    def offset(self) -> float:
        """Distance of the mean planes before deformation [m]."""
        return self.state.offset * self.width

    @property
    def area(self) -> float:
        """Area of contact where it is now, projected on the plane, over the nominal area: nodes counted."""
        return float(np.mean(self.shares * self.in_contact))

    @property
    def material_area(self) -> float:
        """Share of the undeformed surface that is in contact: nodes counted."""
        return float(np.mean(self.in_contact))

    @property
    def true_area(self) -> float:
        """Area of contact along the profile over the nominal area: nodes counted."""
        slope = self.press.below(self.state.field).slope
        stretch = np.sqrt(1 + np.sum(slope**2, axis=-1))
        return float(np.mean(self.shares * stretch * self.in_contact))

    @property
    def energy(self) -> float:
        """Stored energy over the nominal area [J/m^2]."""
        cells, (nx, ny) = self.press.cells, self.mesh.cells
        stored = cells.energy(cells.strained(self.state.field))
        return stored * self.solid.young * self.width / (nx * ny * self.mesh.aspect)

    @property
    def residual(self) -> float:
        """Forces that nothing balances over those of the contact, recomputed; or the error of the load."""
        return self.press.residual(self.state)

    @property
    def sideways(self) -> float:
        """Mean force along the plane over the load; 0 for a body that is the same everywhere."""
        slope = self.press.below(self.state.field).slope
        return (
            float(np.linalg.norm(np.sum(self.state.force[..., None] * slope, axis=(0, 1)))) / self.press.load
        )


def solve_finite_strain(
    surface: HeightField,
    solid: Solid,
    *,
    mean_pressure: float,
    tolerance: float = 1e-8,
    **mesh: Unpack[MeshOptions],
) -> FiniteStrain:
    """Press a rigid surface into a neo-Hookean block of finite strain, without friction.

    Nothing is linearised: nodes meet the profile where they are, forces are normal to it there, and the cells
    follow a neo-Hookean law that is Hooke's at small strain.

    Parameters
    ----------
    surface : HeightField
        Heights of the rigid body, positive towards the block; between its points its Fourier series.
    solid : Solid
        Constants at small strain; `poisson` must be below .5.
    mean_pressure : float
        Load over the nominal area [Pa].
    tolerance : float
        Bound on unbalanced over contact forces, on the error of the load, and on gaps of the contact over
        h_rms.
    **mesh
        `depth`, `growth`, `first_layer`, `element`, as in `solve`;
        the element is ``Hex1`` or ``Hex1/P0``.

    Raises
    ------
    InvalidInput
        For arguments that cannot be used.
    NotConverged
        Where Newton's method does not settle, however small the steps from the flat surface.
    """
    instance("surface", surface, HeightField)
    return next(
        solve_slopes(
            surface,
            solid,
            mean_pressure=mean_pressure,
            slopes=(surface.rms_gradient,),
            tolerance=tolerance,
            **mesh,
        )
    )


def solve_slopes(
    surface: HeightField,
    solid: Solid,
    *,
    mean_pressure: float,
    slopes: Iterable[float],
    tolerance: float = 1e-8,
    **mesh: Unpack[MeshOptions],
) -> Iterator[FiniteStrain]:
    """Press a surface made steeper and steeper at one reduced load p0 / (E* h'_rms).

    Parameters
    ----------
    mean_pressure : float
        Load over the nominal area at the heights given [Pa]; it goes with the slope.
    slopes : iterable of float
        Root mean square gradients to which the heights are scaled, rising.
    surface, solid, tolerance, **mesh
        As in `solve_finite_strain`.

    Yields
    ------
    FiniteStrain
        One for each slope, each started from the one before.

    Raises
    ------
    InvalidInput, NotConverged
        As in `solve_finite_strain`.
    """
    instance("surface", surface, HeightField)
    instance("solid", solid, Solid)
    mean_pressure = positive("mean_pressure", mean_pressure)
    tolerance = within("tolerance", tolerance, "[1e-13, 1e-2]")
    gradient = positive("h'_rms", surface.rms_gradient)
    factors = [slope / gradient for slope in positives("slopes", slopes)]
    if any(after <= before for before, after in itertools.pairwise(factors)):
        raise InvalidInput("slopes: must rise")
    planned = planned_mesh(surface.shape, surface.lengths, poisson=solid.poisson, options=mesh)
    if planned.element.order != 1:
        raise InvalidInput(
            f"element = {planned.element.name!r}, poisson = {solid.poisson!r}: finite strain takes 'Hex1' or "
            "'Hex1/P0', and poisson below 0.5"
        )
    width = surface.spacing[0]
    press = Press(
        cells=Cells(mesh=planned, poisson=solid.poisson),
        hierarchy=build_hierarchy(planned, poisson=solid.poisson),
        profile=Profile.of(surface, unit=width),
        load=mean_pressure / solid.young * planned.cells[0] * planned.cells[1] * planned.aspect,
        roughness=surface.rms_height / width,
        tolerance=tolerance,
        steps=_STEPS,
    )
    linear = solve(surface, solid, mean_pressure=mean_pressure, method="full", tolerance=1e-4, **mesh)
    contact = linear.contact.checked()
    first = State(
        field=linear.field[:, :, 1:] / width,
        offset=contact.offset / width,
        force=contact.pressure / solid.young * planned.aspect,
        nodes=contact.in_contact.copy(),
    )

    def steeper() -> Iterator[FiniteStrain]:
        done, state = 0.0, first
        for factor in factors:
            began = time.process_time()
            state = _steepened(press, state, done, factor)
            done = factor
            yield FiniteStrain(
                press=press.scaled(factor),
                state=state,
                surface=HeightField(heights=factor * surface.heights, lengths=surface.lengths),
                solid=solid,
                mean_pressure=factor * mean_pressure,
                cpu_seconds=time.process_time() - began,
            )

    return steeper()


def _steepened(press: Press, state: State, done: float, factor: float) -> State:
    """Go from one slope to another, in smaller steps where Newton's method does not follow.

    Slope 0 stands for the linear answer, whose scale is that of the heights as given.
    """
    step, aim = factor - done, factor
    while True:
        guess = state.scaled(aim / done if done else aim)
        trial = descend(press.scaled(aim), guess)
        if not trial.trouble:
            state, done = trial, aim
        else:
            step *= 0.5
            if step < _LEAST * factor:
                raise NotConverged(
                    f"finite strain at {aim / factor:.3g} of the slope asked for: {trial.trouble}; take a "
                    "smaller slope or load, or a finer grid"
                )
        if done >= factor:
            return state
        aim = min(done + step, factor)
