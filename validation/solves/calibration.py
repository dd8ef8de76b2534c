"""What each effect costs over a plain elastic solve: measured on this machine, or on the reference machine.

``fem-contact calibrate`` measures and keeps the factors in the user's cache; `explain` and `--dry-run` use
them, and say where they come from.
"""

from __future__ import annotations

import json
import math
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from types import MappingProxyType

from validation.effects.tables import Adhesion, Coating, EffectSpec, Graded, HardnessEffect, Thickness

__all__ = ["REFERENCE", "EffectCosts", "cache_file", "calibrate", "effect_costs"]


@dataclass(frozen=True, kw_only=True)
class EffectCosts:
    """Processor time of a boundary-element solve with an effect over that of the plain one.

    Attributes
    ----------
    factors : mapping of str to float
        By the effect's kind.
    source : str
        Where and when they were measured, in words.
    """

    factors: Mapping[str, float]
    source: str


#: Without a calibration of this machine: one surface on 256 x 256 points, one thread. Adhesion's factor grows
#: with the grid (12 on 512 x 512), that of grading, most of which is set-up, falls (3).
REFERENCE = EffectCosts(
    factors=MappingProxyType(
        {"hardness": 1.4, "adhesion": 5.1, "thickness": 1.0, "coating": 1.4, "graded": 6.1}
    ),
    source="measured on a virtual AMD EPYC, 2026-11-21; 'fem-contact calibrate' measures this machine",
)


def cache_file() -> Path:
    """Where this machine's factors are kept."""
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA", str(Path.home() / "AppData" / "Local"))
    else:
        base = os.environ.get("XDG_CACHE_HOME", str(Path.home() / ".cache"))
    return Path(base) / "fem-contact" / "effect-costs.json"


def effect_costs() -> EffectCosts:
    """Return this machine's factors; those of the reference machine where none, or no good ones, are kept."""
    try:
        kept = json.loads(cache_file().read_text(encoding="utf-8"))
        factors = {str(kind): float(value) for kind, value in kept["factors"].items()}
        measured_on = str(kept["date"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return REFERENCE
    if set(factors) != set(REFERENCE.factors) or not all(
        math.isfinite(value) and value > 0 for value in factors.values()
    ):
        return REFERENCE
    return EffectCosts(factors=MappingProxyType(factors), source=f"measured on this machine, {measured_on}")


def calibrate(
    *, points: int = 256, repeats: int = 3, tell: Callable[[str], None] | None = None
) -> EffectCosts:
    """Measure the factors on this machine and keep them.

    Parameters
    ----------
    points : int
        Along a side of the surface.
    repeats : int
        Solves of each kind after the first, which compiles; the fastest counts.
    tell : callable, optional
        Given a line for every effect.

    Raises
    ------
    UsageError
        Where the cache cannot be written.
    """
    from validation.files import atomic_path, prepare_folder

    folder = prepare_folder(cache_file().parent, option="cache")
    seconds = _measured(points, repeats, tell)
    plain = seconds.pop("plain")
    factors = {kind: value / plain for kind, value in seconds.items()}
    today = date.today().isoformat()
    with atomic_path(folder / cache_file().name) as draft:
        draft.write_text(json.dumps({"date": today, "points": points, "factors": factors}) + "\n")
    return EffectCosts(factors=MappingProxyType(factors), source=f"measured on this machine, {today}")


def _measured(points: int, repeats: int, tell: Callable[[str], None] | None) -> dict[str, float]:
    """Processor seconds of each solve, all on one surface, grid and load, on one thread."""
    from fem_contact.solid import Solid
    from validation.methods.slots import solve_bem
    from validation.scenes.scene import SelfAffineSurface
    from validation.scenes.surfaces import height_field

    surface = SelfAffineSurface(
        kind="self-affine",
        length=(1.0, 1.0),
        hurst=0.8,
        lambda_long=1 / 4,
        lambda_short=1 / 32,
        rms_gradient=0.1,
        seed=8,
    )
    field, solid = height_field(surface, (points, points)), Solid(young=1.0, poisson=0.0)
    cases = _cases(points)
    seconds, pairs = dict.fromkeys(cases, math.inf), dict.fromkeys(cases, 0.0)
    # In turns, and the least processor time counts: other processes of the machine must not decide a ratio.
    for turn in range(repeats + 1):
        for kind, effect in cases.items():
            effects = () if effect is None else (effect,)
            contact = solve_bem(
                field, solid, effects=effects, mean_pressure=0.005, tolerance=1e-8, threads=1
            ).checked()
            if turn > 0:
                seconds[kind] = min(seconds[kind], contact.cost.cpu_seconds)
                pairs[kind] = contact.cost.fft_pairs
    for kind, value in seconds.items():
        if tell is not None:
            ratio = value / seconds["plain"]
            tell(f"{kind:10s} {value:8.3f} s, {ratio:5.2f} times plain, {pairs[kind]:4.0f} FFT pairs")
    return seconds


def _cases(points: int) -> dict[str, EffectSpec | None]:
    """Return one table for each effect, strong enough to matter; the plain solve first."""
    # Attraction and repulsion of the same order; a process zone of three cells.
    work = 5e-5
    reach = math.sqrt(3 / points * work)
    return {
        "plain": None,
        "hardness": HardnessEffect(kind="hardness", hardness=0.06),
        "adhesion": Adhesion(kind="adhesion", work=work, reach=reach),
        "thickness": Thickness(kind="thickness", thickness=0.1),
        "coating": Coating(kind="coating", young=0.3, thickness=0.02),
        "graded": Graded(kind="graded", bulk_young=3.0, depth=0.05),
    }
