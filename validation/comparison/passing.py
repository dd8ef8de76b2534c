"""What passes through contact and gap of a scene, in units: read off its stored solves if it asks for it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fem_contact.conductance import contact_conductance, frozen_contact
from fem_contact.contact import ContactResult
from fem_contact.leak import flow_conductance, open_gap
from fem_contact.response import HalfSpace
from persson.leakage import effective_medium
from persson.scale import Scale
from persson.separation import contact_stiffness
from validation.methods import find_method
from validation.report.table import WordTable
from validation.report.words import significant, with_error
from validation.scenes.quantities import Leak, Quantities
from validation.scenes.realised import Realised
from validation.scenes.scene import Scene
from validation.solves.press import Press

__all__ = ["Passing", "passing", "sentences", "words_table"]

#: What is asked of one result, and what a theory says of it: value, theory's value.
_Read = Callable[[ContactResult], tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class Passing:
    """One quantity of a scene, on the finest grid that resolves its surface.

    Attributes
    ----------
    name : str
        As data name it, such as "thermal_conductance".
    words, unit : str
    value : float
        Infinite where everything touches, so that nothing narrows the current.
    grid_error : float
        How far the value on the grid before lies; NaN from a single grid.
    scatter : float
        Relative standard deviation between the surfaces of the ensemble; NaN without one.
    surfaces : int
        How many it is over.
    method : str
    grid : tuple of int
    theory : float
        What a theory says; NaN where it says nothing.
    beside : str
        Which theory.
    """

    name: str
    words: str
    unit: str
    value: float
    grid_error: float
    scatter: float
    surfaces: int
    method: str
    grid: tuple[int, int]
    theory: float
    beside: str


def passing(scene: Scene, realised: Realised, results: Mapping[Press, ContactResult]) -> tuple[Passing, ...]:
    """Read off what the table [quantities] asks for; empty without it.

    The set of contact is that of the solve, whatever effects made it; the current passes through homogeneous
    half-spaces that touch there, yielded points included.
    """
    if scene.quantities is None:
        return ()
    own, ensemble = _ladder(scene, realised, results)
    if not own:
        return ()
    found = []
    for name, words, unit, read, beside in _asked(scene.quantities, realised, bare=not scene.effects):
        values = [read(results[solve]) for solve in own[-2:]]
        others = [read(results[solve])[0] for solve in ensemble]
        (value, theory), before = values[-1], values[0][0]
        found.append(
            Passing(
                name=name,
                words=words,
                unit=unit,
                value=value,
                grid_error=abs(value - before) if len(values) > 1 and np.isfinite(value) else float("nan"),
                scatter=_scatter(others),
                surfaces=len(others),
                method=own[-1].method,
                grid=own[-1].grid,
                theory=theory,
                beside=beside,
            )
        )
    return tuple(found)


def _ladder(
    scene: Scene, realised: Realised, results: Mapping[Press, ContactResult]
) -> tuple[list[Press], list[Press]]:
    """Solves of the first method whose points weigh alike, coarse to fine, and those of the ensemble."""

    def fine(solve: Press) -> float:
        return realised.points_per_wave(solve.grid)

    own: list[Press] = []
    for name in scene.methods.solvers:
        grids = scene.methods.options(name).grids
        listed = [s for s in results if s.method == name and s.is_own and s.grid in grids]
        resolved = [s for s in listed if realised.resolved_by(s.grid)] or listed
        own = [s for s in sorted(resolved, key=fine) if results[s].weights is None]
        if own:
            break
    if scene.ensemble is None or scene.ensemble_solver is None:
        return own, []
    finest = max(scene.ensemble.grids, key=realised.points_per_wave)
    return own, [
        solve
        for solve in results
        if solve.method == scene.ensemble_solver.name and solve.grid == finest and solve.shift == (0.0, 0.0)
    ]


def _scatter(values: Sequence[float]) -> float:
    mean = float(np.mean(values)) if values else 0.0
    if len(values) < 2 or not np.isfinite(mean) or mean == 0:
        return float("nan")
    return float(np.std(values, ddof=1)) / mean


def _asked(
    quantities: Quantities, realised: Realised, *, bare: bool
) -> Iterator[tuple[str, str, str, _Read, str]]:
    """Yield name, words, unit, how it is read off a result, and whose theory stands beside."""
    if quantities.electrical is not None:
        yield (
            "electrical_conductance",
            "electrical conductance of the contact",
            "1/(ohm m^2)",
            _conductance(quantities.electrical.resistivity, realised, bare=bare),
            "Persson",
        )
    if quantities.thermal is not None:
        first, second = quantities.thermal.conductivity
        yield (
            "thermal_conductance",
            "thermal conductance of the contact",
            "W/(m^2 K)",
            _conductance((1 / first, 1 / second), realised, bare=bare),
            "Persson",
        )
    if quantities.leak is not None:
        axes: tuple[Literal["x", "y"], ...] = ("x", "y")
        for axis in axes:
            yield (
                f"leak_rate_{axis}",
                f"leak through one period along {axis}",
                "m^3/s",
                _leak(quantities.leak, axis),
                "Bruggeman, same gaps",
            )


def _conductance(resistivities: tuple[float, float], realised: Realised, *, bare: bool) -> _Read:
    """Conductance per nominal area, by Barber's relation on the set of contact, yielded points included."""
    half_space = HalfSpace(solid=realised.elastic)
    modulus = half_space.contact_modulus

    def of(stiffness: float) -> float:
        if np.isinf(stiffness):
            return float("inf")
        return contact_conductance(stiffness, contact_modulus=modulus, resistivities=resistivities)

    def read(result: ContactResult) -> tuple[float, float]:
        theory = float("nan")
        if bare:
            scale = Scale(realised.own_spectrum, contact_modulus=modulus)
            theory = of(float(contact_stiffness(result.mean_pressure, scale=scale)))
        if result.in_contact.all():
            return float("inf"), theory
        if not result.in_contact.any():
            return 0.0, theory
        conducting = replace(result, at_bound=np.zeros(result.shape, dtype=bool))
        return of(frozen_contact(conducting, half_space).stiffness), theory

    return read


def _leak(leak: Leak, axis: Literal["x", "y"]) -> _Read:
    """Volume per time through one period, along one axis, and what Bruggeman makes of the same gaps."""

    def read(result: ContactResult) -> tuple[float, float]:
        gap = open_gap(result)
        along, across = result.lengths if axis == "x" else result.lengths[::-1]
        per = leak.pressure_drop / along * across / leak.viscosity
        medium = effective_medium(gap.ravel() ** 3 / 12, np.full(gap.size, 1 / gap.size))
        return per * flow_conductance(gap, result.lengths, axis=axis).conductance, per * medium

    return read


def _words(one: Passing) -> str:
    """Return the value with what the grids leave open, in its unit."""
    if one.value == np.inf:
        return "infinite: contact is complete, and nothing narrows the current"
    if one.value == 0:
        return f"0 {one.unit}" + (": closed, no path leads through" if "leak" in one.name else "")
    return f"{with_error(one.value, one.grid_error)} {one.unit}"


def sentences(found: Sequence[Passing]) -> Iterator[str]:
    """Yield one sentence for each quantity."""
    for one in found:
        where = f"{find_method(one.method).label} on {one.grid[0]} x {one.grid[1]}"
        text = f"The {one.words} is {_words(one)} ({where}; grid: change from the one before)"
        if np.isfinite(one.scatter):
            text += f"; between {one.surfaces} surfaces it scatters by {100 * one.scatter:.2g} %"
        if np.isfinite(one.theory):
            text += f"; {one.beside}: {significant(one.theory)} {one.unit}"
        yield text + "."


def words_table(found: Sequence[Passing]) -> WordTable:
    """Return the quantities as a table of the page."""
    return WordTable(
        title="What passes through contact and gap",
        columns=("quantity", "unit", "value", "between surfaces", "theory", "which"),
        rows=tuple(
            (
                one.words,
                one.unit,
                _words(one).removesuffix(f" {one.unit}"),
                f"{100 * one.scatter:.2g} %" if np.isfinite(one.scatter) else "",
                significant(one.theory),
                one.beside if np.isfinite(one.theory) else "",
            )
            for one in found
        ),
        left=frozenset({"quantity", "unit", "which"}),
        note="Value on the finest grid +- its change from the grid before; between surfaces: standard "
        "deviation of one among those of the ensemble. Conductances are per nominal area, through the spots.",
    )
