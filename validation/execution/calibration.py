"""What each effect costs over a plain elastic solve: measured on this machine, or on the reference machine.

``fem-contact calibrate`` measures and keeps the factors in the user's cache; `explain` and `--dry-run` use
them, and say where they come from.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import platformdirs

from fem_contact.contact import Cost
from fem_contact.solid import Solid
from validation.effects import Effect, effect_kinds
from validation.effects.base import ContactModel
from validation.files import prepare_folder, read_record, write_record
from validation.solvers import find_solver
from validation.solvers.base import example_field


@dataclass(frozen=True, kw_only=True)
class EffectCosts:
    """Processor time of a boundary-element solve with an effect over a plain one, by kind; their source."""

    factors: Mapping[str, float]
    source: str


#: What stands without a calibration of this machine: 256 x 256 points, one thread. Adhesion's factor grows
#: with the grid (12 on 512 x 512); that of grading, most of which is set-up, falls.
_USUAL = "as their files say, for a virtual AMD EPYC; 'fem-contact calibrate' measures this machine"


def cache_file() -> Path:
    """Where this machine's factors are kept."""
    return platformdirs.user_cache_path("fem-contact") / "effect-costs.json"


def effect_costs() -> EffectCosts:
    """Return this machine's factors; those of the reference machine where none, or no good ones, are kept."""
    kinds, bem = effect_kinds(), find_solver("bem")
    usual = {name: kind.cost for name, kind in kinds.items() if kind.slot != "spectrum"}
    try:
        record = read_record(cache_file())
        factors = {str(kind): float(value) for kind, value in record["factors"].items()}
        measured = {name for name, kind in kinds.items() if bem.handles(kind)}
        if set(factors) != measured or not all(0 < value < math.inf for value in factors.values()):
            raise ValueError("not the effects that are measured")
        # What boundary elements are not given is not measured.
        return EffectCosts(factors=usual | factors, source=f"measured on this machine, {record['date']}")
    except FileNotFoundError:
        source = _USUAL
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        words = f"{cache_file()}: damaged, or of another version; 'fem-contact calibrate' makes it again"
        source = f"{_USUAL} ({words})"
    return EffectCosts(factors=usual, source=source)


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
    cases |= {name: (kind.example(1 / points),) for name, kind in effect_kinds().items() if bem.handles(kind)}
    costs: dict[str, list[Cost]] = {name: [] for name in cases}
    # In turns, and the least processor time counts: other processes of the machine must not decide a ratio.
    for _ in range(repeats + 1):
        for name, effects in cases.items():
            contact = bem.pressed(field, ContactModel.filled(solid, effects), 0.005, tolerance=1e-8).checked()
            costs[name].append(contact.cost)
    least = {name: min(each[1:], key=lambda cost: cost.cpu_seconds) for name, each in costs.items()}
    factors = {name: cost.cpu_seconds / least["plain"].cpu_seconds for name, cost in least.items()}
    for name, cost in least.items():
        words = f"{cost.cpu_seconds:8.3f} s, {factors[name]:5.2f} times plain"
        if tell is not None:
            tell(f"{name:10s} {words}, {cost.fft_pairs:4.0f} FFT pairs")
    del factors["plain"]
    today = date.today().isoformat()
    write_record(folder / cache_file().name, {"date": today, "points": points, "factors": factors})
    return EffectCosts(factors=factors, source=f"measured on this machine, {today}")
