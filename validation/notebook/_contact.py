"""A surface pressed on a grid, and everything that a report says of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import xarray as xr

from fem_contact.area import ContactAreas, contact_areas
from fem_contact.contact import ContactResult
from validation.comparison import fields, run_views
from validation.comparison.numbers import scene_data
from validation.comparison.reductions import DIFFERENCES, grid_name
from validation.errors import NoLimit, UsageError
from validation.execution.press import Press, solves_of
from validation.notebook._surface import GridLike, as_html, checked, fast_grid, map_of, on_places
from validation.report.marks import Drawing, draw
from validation.report.quantities import in_prefixed_unit, labelled
from validation.report.values import Value, value_of
from validation.report.words import significant
from validation.scenes.checks import check_scene
from validation.scenes.problem import ContactProblem
from validation.scenes.scene import Scene
from validation.scenes.tables import Load
from validation.solvers.base import Solved
from validation.solvers.theory import Prediction, predict
from validation.units import alike

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fem_contact.patches import Patches
    from fem_contact.subsurface import Subsurface

#: Points per shortest wave of the grids that a limit is taken over unless some are given.
_LADDER = (4.0, 6.0, 8.0)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Contact:
    """A surface pressed on a grid, and everything that a report says of it.

    `scene` is what was asked for, `problem` its surface, solid and load, `solved` what each solve gave.
    """

    scene: Scene
    problem: ContactProblem
    solved: Mapping[Press, Solved]

    @property
    def solve(self) -> Press:
        """The solve of the grid it was pressed on, of several of the finest."""
        method = next(iter(self.solved)).method
        return max((s for s in self.solved if s.method == method), key=lambda s: math.prod(s.grid))

    @property
    def result(self) -> ContactResult:
        """Fields, status, residuals and cost of that solve."""
        return self.solved[self.solve].contact

    @property
    def area(self) -> Value:
        """A/A0, as a report says it; one grid says no error: press on several `grids`, or ask `limit`."""
        return value_of(self.data, "area")

    @property
    def kappa(self) -> Value:
        """A/A0 over p*."""
        return value_of(self.data, "kappa")

    @property
    def mean_gap(self) -> Value:
        """Mean gap [m], where there is contact included."""
        return value_of(self.data, "mean_gap")

    @property
    def approach(self) -> Value:
        """How far the bodies approached since the mean planes met [m]."""
        return value_of(self.data, "approach")

    @property
    def max_pressure(self) -> Value:
        """Largest contact pressure [Pa]."""
        return value_of(self.data, "largest_pressure")

    @property
    def stiffness(self) -> Value:
        """Contact stiffness K h_rms / p0, of the contact set as it is.

        Raises
        ------
        UsageError
            Where it does not follow from the contact set: finite elements, adhesion, full contact.
        """
        if "stiffness" not in self.data:
            only = "partial contact of boundary elements without adhesion alone"
            raise UsageError(f"stiffness: it follows from {only}")
        return value_of(self.data, "stiffness")

    def areas(self) -> ContactAreas:
        """Return A/A0 counted, and corrected at the edge by the constant of the discretisation."""
        return contact_areas(self.result, edge_constant=self.solve.solver.edge_constant(self.result))

    def limit(self, grids: Sequence[GridLike] | None = None) -> Value:
        """Return A/A0 in the limit of vanishing spacing, with half of its 95 % interval: grid and solver.

        Parameters
        ----------
        grids : sequence, optional
            Grids it is taken over; if not given those it was pressed on, of one 4, 6, 8 points per wave.

        Raises
        ------
        NoLimit
            Where these grids tell none, with the reason.
        """
        several = grids is None and len({solve.grid for solve in self.solved}) > 1
        data = (self if several else self._on(grids)).data
        if why := str(data.no_limit.item()):
            raise NoLimit(why)
        return value_of(data, "area_own")

    def against(self, method: str = "fem") -> xr.Dataset:
        """Press by another method on the same grid, and return how far the two are apart.

        ``pressure_difference`` is the relative L2 norm; ``area_pixel_difference`` and
        ``area_perimeter_difference`` are relative, too.
        """
        if not isinstance(method, str) or method == self.solve.method:
            raise UsageError(f"against: it was pressed by {self.solve.method!r}; name another method")
        data = self._by({**dict(self.scene.methods), method: {"grids": [self.solve.grid]}}).data
        return data[list(DIFFERENCES)].sel(solver=method, grid=grid_name(self.solve.grid))

    @cached_property
    def data(self) -> xr.Dataset:
        """Every number that a run reports: of each method, grid and shift, and of the theory beside."""
        results = {solve: solved.contact for solve, solved in self.solved.items()}
        return scene_data(self.scene, self.problem, results)

    @property
    def findings(self) -> tuple[str, ...]:
        """What a run would say of it."""
        return tuple(finding.text for finding in run_views.run_views(self.data).findings)

    @cached_property
    def theory(self) -> Prediction | None:
        """What Persson's theory says of this surface; None where it does not know an effect."""
        options = self.scene.methods.options("theory")
        return None if options is None else predict(self._loaded, self.scene.effects, options)

    @property
    def _loaded(self) -> ContactProblem:
        problem = self.problem
        return problem.under(Load(pressure=self.result.mean_pressure)) if problem.load.held else problem

    def patches(self) -> Patches:
        """Return the connected patches of the contact and their areas [m^2]."""
        from fem_contact.patches import find_patches

        return find_patches(self.result.in_contact, self.result.spacing, periodic=self.result.periodic)

    def to_xarray(self) -> xr.Dataset:
        """Return the fields over x and y with units: pressure, gap, displacement, heights, contact."""
        from validation.execution.press import fields_dataset

        return fields_dataset(self.result, recipe=self.solve.recipe_text)

    def below(self, depths: Sequence[float] | None = None) -> Subsurface:
        """Return displacement and stress below the contact, from its pressures, at depths [m].

        Raises
        ------
        UsageError
            For finite elements, whose block has a stress of its own.
        """
        from fem_contact.subsurface import fields_below

        if self.solve.solver.sinks:
            remedy = "write its own stress with to_vtu(...)"
            raise UsageError(f"below: method {self.solve.method!r} meshes its body; {remedy}")
        return fields_below(self.result, self.solve.below, depths=depths)

    def to_vtu(self, path: str | Path) -> Path:
        """Write the stress in the solid for ParaView or pyvista: of the block, or else below the contact.

        Raises
        ------
        UsageError
            For a method that meshes a body and does not keep it.
        """
        from fem_contact.export import write_block, write_subsurface

        block = self.solved[self.solve].block
        if block is not None:
            write_block(Path(path), block)
        else:
            write_subsurface(Path(path), self.below())
        return Path(path)

    def plot(
        self,
        what: Literal["pressure", "gap", "distribution", "grids"] = "pressure",
        *,
        ax: Axes | Sequence[Axes] | None = None,
    ) -> Drawing:
        """Draw the map of pressure or gap, P(sigma) beside the theory, or area against grid spacing.

        A notebook shows it; ``.figure.savefig(...)`` writes it, ``.data`` has its numbers. With `ax` it is
        drawn into axes of matplotlib; P(sigma) takes two, near zero and as far as it goes.
        """
        own = {self.solve: self.result}
        match what if isinstance(what, str) else None:
            case "pressure":
                data = labelled(fields.with_maps(self.data, own))
                return draw(run_views.maps_figure(data), data, axes=ax)
            case "gap":
                from fem_contact.leak import open_gap

                data = on_places(self.data, self.result.spacing, gap_map=open_gap(self.result))
                return draw(map_of("gap_map", "Gap between the surfaces."), data, axes=ax)
            case "distribution":
                data = labelled(fields.with_distribution(self.data, own, self.scene, self._loaded))
                return draw(run_views.pressure_figure(data), data, axes=ax)
            case "grids":
                return draw(run_views.area_figure(), self._on().data, axes=ax)
        raise UsageError(f"plot: {what!r} is not drawn; one of: 'pressure', 'gap', 'distribution', 'grids'")

    def _on(self, grids: Sequence[GridLike] | None = None) -> Contact:
        """Press on other grids, if not given on 4, 6, 8 points per wave."""
        name, problem = self.solve.method, self.problem
        if grids is None:
            grids = [fast_grid(problem.lengths, problem.shortest, points) for points in _LADDER]
        options = self.scene.methods.options(name).model_dump(exclude_unset=True)
        return self._by({name: {**options, "grids": grids}})

    def _by(self, methods: Mapping[str, Any]) -> Contact:
        """Press by other methods; what is solved is not solved again."""
        asked = {**dict(self.scene), "methods": {"theory": self.scene.methods.options("theory"), **methods}}
        return pressed(checked(Scene, "press", asked), self.problem, done=self.solved)

    @property
    def _facts(self) -> dict[str, str]:
        theory, loaded = self.theory, self._loaded
        pressure = alike(loaded.pressure, self.scene.load.pressure)
        facts = {
            "solve": self.solve.label,
            "p0": f"{in_prefixed_unit(pressure, 'Pa')} (p* = {loaded.reduced_pressure:.4g})",
            "A/A0": f"{self.area} ({self.data.area_basis.item()}; counted {significant(self.areas().pixel)})",
        }
        if theory is not None:
            facts["A/A0, Persson"] = significant(theory.area) if math.isfinite(theory.area) else theory.note
        measured = self.problem.measured
        doubts = {} if measured is None or not measured.doubts else {"doubts": "; ".join(measured.doubts)}
        return {**facts, "residual": f"{self.result.residuals.worst:.1e}", **doubts}

    def __repr__(self) -> str:
        return "<contact: " + ", ".join(f"{name} = {value}" for name, value in self._facts.items()) + ">"

    def _repr_html_(self) -> str:
        return as_html("contact", self._facts)


def pressed(scene: Scene, problem: ContactProblem, *, done: Mapping[Press, Solved]) -> Contact:
    """Solve what a scene asks for, in this process; what is done is not done again."""
    check_scene(scene, problem)
    solved = {solve: done.get(solve) or solve.do() for solve in solves_of(scene, problem)}
    return Contact(scene=scene, problem=problem, solved=solved)
