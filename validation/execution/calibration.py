"""What each effect costs over a plain elastic solve: measured on this machine, or on the reference machine.

``fem-contact calibrate`` measures and keeps the factors in the user's cache; `explain` and `--dry-run` use
them, and say where they come from.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from datetime import date
from pathlib import Path
from types import MappingProxyType

import platformdirs

from fem_contact.solid import Solid
from validation.effects import Effect, effect_kinds
from validation.effects.base import ContactModel
from validation.files import prepare_folder, read_record, write_record
from validation.solvers import Solver, find_solver, methods
from validation.solvers.base import example_field


@dataclass(frozen=True, kw_only=True)
class EffectCosts:
    """Processor time of a boundary-element solve with an effect over a plain one, by kind; their source."""

    factors: Mapping[str, float]
    source: str


def reference() -> EffectCosts:
    """Return what stands without a calibration of this machine: 256 x 256 points, one thread.

    Adhesion's factor grows with the grid (12 on 512 x 512); that of grading, most of which is set-up, falls.
    """
    solvers = [method for method in methods().values() if isinstance(method, Solver)]
    solved = {name: kind for name, kind in effect_kinds().items() if any(m.handles(kind) for m in solvers)}
    return EffectCosts(
        factors=MappingProxyType({name: kind.cost for name, kind in solved.items()}),
        source="as their files say, for a virtual AMD EPYC; 'fem-contact calibrate' measures this machine",
    )


def cache_file() -> Path:
    """Where this machine's factors are kept."""
    return platformdirs.user_cache_path("fem-contact") / "effect-costs.json"


def effect_costs() -> EffectCosts:
    """Return this machine's factors; those of the reference machine where none, or no good ones, are kept."""
    try:
        record = read_record(cache_file())
        factors = {str(kind): float(value) for kind, value in record["factors"].items()}
        measured = {name for name, kind in effect_kinds().items() if find_solver("bem").handles(kind)}
        if set(factors) != measured or not all(0 < value < math.inf for value in factors.values()):
            raise ValueError("not the effects that are measured")
        source = f"measured on this machine, {record['date']}"
    except FileNotFoundError:
        return reference()
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        words = f"{cache_file()}: damaged, or of another version; 'fem-contact calibrate' makes it again"
        return replace(reference(), source=f"{reference().source} ({words})")
    # What boundary elements are not given is not measured.
    return EffectCosts(factors=MappingProxyType({**reference().factors, **factors}), source=source)


def calibrate(
    *, points: int = 256, repeats: int = 3, tell: Callable[[str], None] | None = None
) -> EffectCosts:
    """Measure the factors on this machine and keep them; a UsageError where the cache cannot be written.

    All on one surface of so many `points` along a side, grid and load, on one thread; of the `repeats` of
    each solve after the first, which compiles, the fastest counts. `tell` is given a line for every effect.
    """
    folder = prepare_folder(cache_file().parent, option="cache")
    field, solid, bem = example_field(points), Solid(young=1.0, poisson=0.0), find_solver("bem")
    cases: dict[str, tuple[Effect, ...]] = {"plain": ()}
    cases |= {name: (kind.example(1 / points),) for name, kind in effect_kinds().items()}
    cases = {name: effects for name, effects in cases.items() if all(bem.handles(type(e)) for e in effects)}
    seconds, pairs = dict.fromkeys(cases, math.inf), dict.fromkeys(cases, 0.0)
    # In turns, and the least processor time counts: other processes of the machine must not decide a ratio.
    for turn in range(repeats + 1):
        for name, effects in cases.items():
            contact = bem.pressed(field, ContactModel.filled(solid, effects), 0.005, tolerance=1e-8).checked()
            if turn > 0:
                seconds[name] = min(seconds[name], contact.cost.cpu_seconds)
                pairs[name] = contact.cost.fft_pairs
    factors = {name: value / seconds["plain"] for name, value in seconds.items()}
    for name, factor in factors.items():
        if tell is not None:
            words = f"{seconds[name]:8.3f} s, {factor:5.2f} times plain"
            tell(f"{name:10s} {words}, {pairs[name]:4.0f} FFT pairs")
    del factors["plain"]
    today = date.today().isoformat()
    write_record(folder / cache_file().name, {"date": today, "points": points, "factors": factors})
    return EffectCosts(factors=MappingProxyType(factors), source=f"measured on this machine, {today}")
