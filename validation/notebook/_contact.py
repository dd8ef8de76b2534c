"""A surface pressed on a grid, and everything that a report says of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from fem_contact.area import ContactAreas, contact_areas
from fem_contact.contact import ContactResult
from fem_contact.extrapolation import Limit
from validation.comparison.compare import compare
from validation.comparison.compared import Comparison, CrossCheck
from validation.effects.base import Slots
from validation.errors import UsageError
from validation.methods.base import Solved
from validation.methods.theory import Prediction
from validation.notebook._tables import GridLike, as_html, checked, fast_grid
from validation.report.words import significant
from validation.scenes.checks import check_scene
from validation.scenes.realised import Realised
from validation.scenes.scene import Scene
from validation.solves.press import Press, solves_of

if TYPE_CHECKING:
    import xarray as xr

    from fem_contact.patches import Patches
    from fem_contact.subsurface import Subsurface
    from validation.report.drawing import Drawing

__all__ = ["Contact", "pressed"]

#: Points per shortest wave of the grids that a limit is taken over unless some are given.
_LADDER = (4.0, 6.0, 8.0)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Contact:
    """A surface pressed on a grid, and everything that a report says of it.

    Attributes
    ----------
    scene : Scene
        What was asked for.
    realised : Realised
        Its surface, solid and load.
    solved : mapping
        What each solve gave.
    """

    scene: Scene
    realised: Realised
    solved: Mapping[Press, Solved]

    @property
    def solve(self) -> Press:
        """The first solve: that of the grid it was pressed on."""
        return next(iter(self.solved))

    @property
    def result(self) -> ContactResult:
        """Fields, status, residuals and cost of that solve."""
        return self.solved[self.solve].contact

    def areas(self) -> ContactAreas:
        """Return A/A0 counted, and corrected at the edge by the constant of the discretisation."""
        return contact_areas(self.result, edge_constant=self.solve.solver.edge_constant(self.result))

    def limit(self, grids: Sequence[GridLike] | None = None) -> Limit:
        """Return A/A0 in the limit of vanishing spacing, with its standard error.

        Parameters
        ----------
        grids : sequence, optional
            Grids it is taken over; 4, 6 and 8 points per shortest wave if not given.
        """
        found = self._on(grids or [self._grid(n) for n in _LADDER]).comparison
        if found.limit is not None:
            return found.limit
        return Limit(
            value=math.nan,
            uncertainty=math.nan,
            edge_constant=math.nan,
            grids=len(found.rows),
            doubt=found.no_limit,
        )

    def against(self, method: str = "fem") -> CrossCheck:
        """Press by another method on the same grid, and return how far the two are apart."""
        if method == self.solve.method:
            raise UsageError(f"against: it was pressed by {method!r}; name another method")
        other = {method: {"grids": [self.solve.grid]}}
        (check,) = pressed(self._methods(other), self.realised, done=self.solved).comparison.cross
        return check

    @cached_property
    def comparison(self) -> Comparison:
        """What a run reports: rows, cross-checks, limit, theory, and findings in words."""
        results = {solve: solved.contact for solve, solved in self.solved.items()}
        return compare(self.scene, self.realised, results)

    @property
    def theory(self) -> Prediction | None:
        """What Persson's theory says of this surface; None where it does not know an effect."""
        return self.comparison.theory

    def patches(self) -> Patches:
        """Return the connected patches of the contact and their areas [m^2]."""
        from fem_contact.patches import find_patches

        return find_patches(self.result.in_contact, self.result.spacing)

    def to_xarray(self) -> xr.Dataset:
        """Return the fields over x and y with units: pressure, gap, displacement, heights, contact."""
        from validation.solves.fields import encode_result
        from validation.solves.netcdf import read_dataset

        return read_dataset(encode_result(self.result, recipe=self.solve.recipe_text))

    def below(self, depths: Sequence[float] | None = None) -> Subsurface:
        """Return displacement and stress below the contact, from its pressures, at depths [m].

        Raises
        ------
        UsageError
            For finite elements, whose block has a stress of its own.
        """
        from fem_contact.subsurface import fields_below

        if self.solve.solver.sinks:
            raise UsageError(
                f"below: method {self.solve.method!r} meshes its body; write its own stress with to_vtu(...)"
            )
        return fields_below(self.result, self._slots.felt_response, depths=depths)

    def to_vtu(self, path: str | Path) -> Path:
        """Write the stress in the solid for ParaView or pyvista: of the block, or else below the contact.

        Raises
        ------
        UsageError
            For a method that meshes a body and does not keep it.
        """
        from fem_contact.export import write_block, write_subsurface

        block = self.solved[self.solve].block
        if block is not None and self.solve.has_block:
            write_block(Path(path), block)
        else:
            write_subsurface(Path(path), self.below())
        return Path(path)

    @property
    def _slots(self) -> Slots:
        return Slots.filled(self.realised.elastic, self.scene.effects)

    def plot(self, what: Literal["pressure", "distribution", "grids"] = "pressure") -> Drawing:
        """Draw the map of pressure, P(sigma) beside the theory, or area against grid spacing.

        A notebook shows it; ``.figure.savefig(...)`` writes it, ``.data`` has its numbers.
        """
        from validation.comparison import figure_data, plots
        from validation.report.drawing import Drawing

        if what == "pressure":
            maps = {self.solve.label: self.result}
            figure, data = (
                plots.pressure_maps_figure(self.comparison, maps),
                figure_data.pressure_maps_data(maps),
            )
            return Drawing(
                name=what, figure=figure, data=data, caption="Contact pressure; white: no contact."
            )
        if what == "distribution":
            curves = {self.solve.label: [self.result]}
            top = figure_data.largest_pressure(self.comparison, curves)
            data = figure_data.pressure_at_zero_data(self.comparison, curves, top=top)
            words = (
                "Distribution of contact pressure per nominal area; no contact, a delta at zero, is left out."
            )
            return Drawing(name=what, figure=plots.pressure_at_zero_figure(data), data=data, caption=words)
        if what == "grids":
            found = self._on([self._grid(n) for n in _LADDER]).comparison
            words = "Contact area against grid spacing, its limit, and the theory."
            data = figure_data.area_data(found)
            return Drawing(name=what, figure=plots.area_figure(found), data=data, caption=words)
        raise UsageError(f"plot: {what!r} is not drawn; one of: 'pressure', 'distribution', 'grids'")

    def _grid(self, points_per_wave: float) -> tuple[int, int]:
        return fast_grid(self.realised.lengths, self.realised.shortest, points_per_wave)

    def _on(self, grids: Sequence[GridLike]) -> Contact:
        """Press on other grids; those that are solved are not solved again."""
        name = self.solve.method
        options = self.scene.methods.options(name).model_dump(exclude_unset=True)
        methods = {name: {**options, "grids": list(grids)}}
        return pressed(self._methods(methods, alone=True), self.realised, done=self.solved)

    def _methods(self, methods: Mapping[str, Any], *, alone: bool = False) -> Scene:
        kept = {} if alone else dict(self.scene.methods)
        theory = {"theory": self.scene.methods.options("theory")}
        return checked(Scene, "press", {**dict(self.scene), "methods": {**kept, **theory, **methods}})

    @property
    def _facts(self) -> dict[str, str]:
        areas, theory = self.areas(), self.theory
        facts = {
            "solve": self.solve.label,
            "p0": f"{self.realised.pressure:.4g} Pa (p* = {self.realised.reduced_pressure:.4g})",
            "A/A0": f"{significant(areas.perimeter)} (counted {significant(areas.pixel)})",
        }
        if theory is not None:
            facts["A/A0, Persson"] = significant(theory.area) if theory.answers else theory.note
        return {**facts, "residual": f"{self.result.residuals.worst:.1e}"}

    def __repr__(self) -> str:
        return "<contact: " + ", ".join(f"{name} = {value}" for name, value in self._facts.items()) + ">"

    def _repr_html_(self) -> str:
        return as_html("contact", self._facts)


def pressed(scene: Scene, realised: Realised, *, done: Mapping[Press, Solved]) -> Contact:
    """Solve what a scene asks for, in this process; what is done is not done again.

    Raises
    ------
    UsageError
        For what cannot be pressed.
    FemContactError
        When a solve fails.
    """
    check_scene(scene, realised)
    solves = solves_of(scene, realised)
    return Contact(
        scene=scene, realised=realised, solved={solve: done.get(solve) or solve.do() for solve in solves}
    )
