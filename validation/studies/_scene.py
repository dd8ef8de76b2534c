"""Studies on a scene: whatever it says counts in place of the options that say the same, or is refused by name."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

from pydantic import Field, model_validator

from validation.arrays import Grid
from validation.effects.base import SlotName, effect_key
from validation.execution.measurement import Call
from validation.execution.press import Press
from validation.measurements.by_solver import beside_bem
from validation.measurements.common import BASE_SOLID, base_case, merged_loads
from validation.measurements.measurement import grids_for
from validation.scenes.checks import check_scene
from validation.scenes.problem import ContactProblem, realise
from validation.scenes.scene import EffectSpec, Scene, load_scene
from validation.scenes.tables import FileSurface, Load
from validation.solvers import chosen_solver, find_solver
from validation.solvers.base import Settings
from validation.solvers.theory import Prediction, predict
from validation.studies._options import Bandwidth, Periods, SurfaceOptions, Surfaces
from validation.units import wrong


@dataclass(frozen=True)
class SolverRequest:
    """A solver as it was named: a method, or a function of the user's, of the name of a method."""

    name: str
    method: str
    settings: Settings
    grids: tuple[Grid, ...]

    def beside_bem(self, problem: ContactProblem, grid: Grid, **how: Any) -> Call:
        """Return its solve of a problem on a grid, beside boundary elements."""
        return beside_bem(problem=problem, grid=grid, method=self.method, settings=self.settings, **how)


class PressedOptions(SurfaceOptions):
    """Options of a study that presses the surfaces of one spectrum: its own, or those of a scene."""

    # Options of parts that make surfaces of their own: on a scene none, or False.
    off: ClassVar[tuple[str, ...]] = ()
    # Of the effects that its question allows, and why no others.
    slots: ClassVar[frozenset[SlotName]] = frozenset()
    plain: ClassVar[str] = "it compares with the elastic half-space"

    scene: Scene | None = Field(default=None, description="surface, solid, load, effects and grids")
    periods: Periods = 4.0
    bandwidth: Bandwidth = 8.0
    surfaces: Surfaces = 8

    @model_validator(mode="before")
    @classmethod
    def _as_the_scene_says(cls, data: Any) -> Any:
        """Take from a scene what it says, and refuse options that say it again.

        Grids that are given replace its own, a number of surfaces counts where they are drawn, loads lead to its.
        """
        scene = data.get("scene") if isinstance(data, dict) else None
        if scene is None:
            return data
        if isinstance(scene, str):
            scene = load_scene(scene)
        if not isinstance(scene, Scene):
            return data  # refused as what it is
        if scene.methods.options("bem") is None:
            raise wrong(
                f"scene {scene.name!r}: methods.bem: missing; this study presses by boundary elements"
            )
        for k, effect in enumerate(scene.effects):
            if effect.slot not in cls.slots:
                key = f"{effect_key(k, 'kind')} = {effect.kind!r}"
                raise wrong(f"scene {scene.name!r}: {key}: not in this study: {cls.plain}")
        first = replace(realise(scene), drawn=True)
        scene = cls._on_grids(scene, first, data)
        check_scene(scene, first)
        taken = cls.taken(scene, first)
        if not isinstance(scene.surface, FileSurface) and "surfaces" in data:
            taken.pop("surfaces", None)
        twice = (set(taken) - {"points_per_wave", "grids"}) | set(_SPECTRUM)
        if clashes := [name for name in data if name in twice]:
            raise wrong("; ".join(_clash(name, off=name in cls.off, scene=scene.name) for name in clashes))
        if "reduced_pressures" in cls.model_fields:
            path = data.get("reduced_pressures", cls.model_fields["reduced_pressures"].default)
            taken["reduced_pressures"] = merged_loads(path, first)
        return {**data, **taken, "scene": scene}

    @classmethod
    def _on_grids(cls, scene: Scene, first: ContactProblem, data: Mapping[str, Any]) -> Scene:
        name = "grids" if "grids" in cls.model_fields else "points_per_wave"
        values, methods = data.get(name), scene.methods
        positive = all(isinstance(value, (int, float)) and value > 0 for value in values or ())
        if not values or name not in cls.model_fields or not positive:
            return scene  # or the option is refused
        lx, ly = first.lengths
        if name == "grids":
            grids = tuple((int(n), round(n * ly / lx)) for n in values)
        else:
            grids = grids_for(first, values)
        table = methods.options("bem").model_copy(update={"grids": grids})
        return scene.model_copy(update={"methods": methods.model_copy(update={"bem": table})})

    @classmethod
    def taken(cls, scene: Scene, first: ContactProblem) -> dict[str, Any]:
        """Return the options that a scene says, with their values."""
        table, fields = scene.methods.options("bem"), cls.model_fields
        options: dict[str, Any] = {n: False if fields[n].annotation is bool else () for n in cls.off}
        if "reduced_pressure" in fields:
            options["reduced_pressure"] = first.reduced_pressure
        if "points_per_wave" in fields:
            options["points_per_wave"] = tuple(sorted(map(first.points_per_wave, table.grids)))
        if "grids" in fields:
            options["grids"] = tuple(nx for nx, _ in sorted(table.grids, key=first.points_per_wave))
        if "methods" in fields:
            options["methods"] = tuple(
                getattr(scene.methods.options(name), "solver", name) for name in scene.methods.solvers
            )
        if "shifts" in fields and "shifts" in table.model_fields_set:
            options["shifts"] = table.shifts
        if isinstance(scene.surface, FileSurface):
            options["surfaces"] = 1
        elif scene.ensemble is not None:
            options["surfaces"] = scene.ensemble.realisations
        return options

    @classmethod
    def fixed_by_scene(cls) -> Mapping[str, str]:
        """Return the options that are refused with a scene, each with the reason."""
        named = (*_SPECTRUM, "poisson", "reduced_pressure", "methods")
        by_scene = dict.fromkeys(named, "; a SCENE says it instead")
        return by_scene | dict.fromkeys(cls.off, "; left out with a SCENE")

    @cached_property
    def first(self) -> ContactProblem:
        """The first surface with its solid and load."""
        if self.scene is not None:
            first = replace(realise(self.scene), drawn=True)
            scattered = getattr(first.surface, "amplitudes", "") == "gaussian" and not first.load.held
            if scattered and "reduced_pressure" in type(self).model_fields:  # one p*, not one p0, for all
                return first.under(Load(reduced_pressure=first.reduced_pressure))
            return first
        solid = BASE_SOLID.model_copy(update=self.model_dump(include={"poisson"}))
        loads = getattr(self, "reduced_pressures", ()) or (getattr(self, "reduced_pressure", None),)
        return base_case(self.self_affine(), reduced_pressure=loads[0], solid=solid)

    @cached_property
    def pressed(self) -> tuple[ContactProblem, ...]:
        """All surfaces."""
        return tuple(self.first.further(k) for k in range(self.surfaces))

    @property
    def effects(self) -> tuple[EffectSpec, ...]:
        """Effects of the scene; none without one."""
        return () if self.scene is None else self.scene.effects

    def predicted(self, problem: ContactProblem) -> Prediction:
        """Return what Persson's theory says of a surface, by the readings of the scene."""
        scene = self.scene
        return predict(problem, self.effects, None if scene is None else scene.methods.options("theory"))

    def press(self, *, surface: int, reduced_pressure: float, grid: Grid) -> Press:
        """Return one solve whose fields are kept, as a run of the scene does it where its load is that."""
        scene, problem = self.scene, self.pressed[surface]
        if abs(reduced_pressure / problem.reduced_pressure - 1) > 1e-12:
            problem = replace(problem, load=Load(reduced_pressure=reduced_pressure))
        return Press(
            method="bem",
            grid=grid,
            problem=problem,
            settings=() if scene is None else find_solver("bem").settings(scene.methods.options("bem")),
            effects=self.effects,
        )

    def grids_for(self, per_wave: Sequence[float], *, of: str = "bem") -> tuple[Grid, ...]:
        """Return the grids of a method, coarse first: those of the scene, or with so many points per wave."""
        table = None if self.scene is None else self.scene.methods.options(of)
        if table is None:
            return grids_for(self.first, per_wave)
        return tuple(sorted(table.grids, key=self.first.points_per_wave))

    def block(
        self, element: str, per_wave: Sequence[float], *, method: str = "reduced", name: str = ""
    ) -> SolverRequest:
        """Return a block of finite elements one period deep, with so many points per wave."""
        settings = (("method", method), ("element", element))
        return SolverRequest(name or element, "fem", settings, grids_for(self.first, per_wave))

    def others(
        self, per_wave: Sequence[float], *, without: Sequence[str] | None = None
    ) -> tuple[SolverRequest, ...]:
        """Return the solvers that are asked for, each with what it is told and its grids, `per_wave` without a scene.

        But for those that the study asks in a way of its own: boundary elements, and finite ones without a scene.
        """
        scene = self.scene
        left = without if without is not None else ("bem",) if scene else ("bem", "fem")
        if scene is None:
            chosen = {n: chosen_solver(n) for n in getattr(self, "methods", ()) if n not in left}
            rows = [(n, solver.name, tuple(settings.items())) for n, (solver, settings) in chosen.items()]
        else:
            solvers = {n: s for n, s in scene.methods.solvers.items() if n not in left}
            tables = {n: scene.methods.options(n) for n in solvers}
            rows = [(getattr(tables[n], "solver", n), n, s.settings(tables[n])) for n, s in solvers.items()]
        return tuple(
            SolverRequest(n, by, settings, self.grids_for(per_wave, of=by)) for n, by, settings in rows
        )

    def _with_methods(self, names: tuple[str, ...]) -> Self | None:
        if self.scene is None:
            return super()._with_methods(names)
        methods = self.scene.methods
        left = [n for n in methods.solvers if getattr(methods.options(n), "solver", n) not in names]
        fewer = self.scene.model_copy(update={"methods": methods.model_copy(update=dict.fromkeys(left))})
        said = {*self.taken(self.scene, self.first), "scene"} - {"surfaces", "reduced_pressures"}
        if isinstance(self.scene.surface, FileSurface):
            said |= {"surfaces"}
        return self._with(self.model_fields_set - said, scene=fewer)

    def tolerance(self, usual: float) -> float:
        """Return the tolerance of boundary elements: that of the scene where it says one."""
        said = {} if self.scene is None else self.scene.methods.options("bem").model_dump(exclude_unset=True)
        return float(said.get("tolerance", usual))

    @property
    def spectrum_words(self) -> dict[str, float]:
        """H, L/lambda_long and lambda_long/lambda_short, for a dataset; H of a self-affine surface alone."""
        problem, numbers = self.first, {"periods": self.periods, "bandwidth": self.bandwidth}
        if self.scene is not None:
            long = problem.longest
            numbers = {"periods": problem.periods, "bandwidth": long / problem.shortest}
        return {**problem.surface.model_dump(include={"hurst"}, exclude_none=True), **numbers}

    def record(self) -> dict[str, Any]:
        """Return what was asked, as JSON-ready data: a scene in full, and no option that it stands in for."""
        if self.scene is None:
            return super().record()
        json: dict[str, Any] = {"mode": "json", "exclude_none": True}
        seed = self.scene.surface.model_dump(include={"seed"}, **json)
        options = self.model_dump(exclude=set(_SPECTRUM), **json)
        return {**options, **seed, "scene": self.scene.model_dump(**json)}

    def remarks(self) -> Iterator[str]:
        """Say what a scene was asked for, and what of it is not used."""
        if (scene := self.scene) is None:
            return
        first, surface, fields = self.first, scene.surface, type(self).model_fields
        what = str(surface.path) if isinstance(surface, FileSurface) else surface.kind
        effects = "".join(f", {effect.kind}" for effect in self.effects)
        values = "; ".join(
            f"{name.replace('_', ' ')} {_shown(value)}"
            for name, value in self.taken(scene, first).items()
            if name not in self.off and _shown(value) == _shown(getattr(self, name))
        )
        yield (
            f"Surface ({what}), solid and load (p* = {first.reduced_pressure:.4g}{effects}) are those of the scene "
            f"{scene.name!r}, and so are: {values}."
        )
        others = ", ".join(f"[methods.{name}]" for name in scene.methods.solvers if name != "bem")
        if others and "methods" not in fields:
            yield f"Not used of the scene, for this study presses by boundary elements: {others}."
        shifts = "shifts" in scene.methods.options("bem").model_fields_set - fields.keys()
        idle = ["methods.bem.shifts"] * shifts + ["ensemble.grids"] * (scene.ensemble is not None)
        if idle := idle + ["surface.more_paths"] * bool(getattr(surface, "more_paths", ())):
            yield f"Keys of the scene that this study has no use for: {', '.join(idle)}."
        if names := ", ".join(name.replace("_", " ") for name in self.off):
            yield f"Parts of the study that a scene turns off: {names}."


#: Options that a scene stands in for, and the keys by which it says the same.
_KEYS = {
    "hurst": "surface.hurst",
    "seed": "surface.seed",
    "periods": "surface.length",
    "bandwidth": "surface.lambda_short",
    "reduced_pressure": "load.reduced_pressure",
    "shifts": "methods.bem.shifts",
}
_SPECTRUM = frozenset({"hurst", "periods", "bandwidth", "seed"})


def _clash(name: str, *, off: bool, scene: str) -> str:
    flag = "--" + name.replace("_", "-")
    if off:
        return f"{flag}: is of a part with surfaces of its own, left out on a scene; leave {flag} out"
    remedy = f"set it there, by --set {_KEYS[name]}=..., or leave" if name in _KEYS else "leave"
    return f"{flag}: the scene {scene!r} says it; {remedy} {flag} out"


def _shown(value: Any) -> str:
    values = value if isinstance(value, tuple) else (value,)
    return ", ".join(f"{v:.6g}" if isinstance(v, float) else str(v) for v in values)
