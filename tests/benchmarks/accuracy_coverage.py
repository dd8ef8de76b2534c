"""How often `run --accuracy` keeps what it claims: surfaces, loads and targets drawn at random.

H = .1 to 1, lambda_long/lambda_short = 2 to 8, at most 8 shortest waves on the period, exact or random
amplitudes, p* = .01 to .6, and an accuracy of 5 % to .2 % that is asked for; with a hardness of .1 to
1.5 E* h'_rms, or a layer of .05 to 1 periods on a rigid base, of 10 % to 1 %; stretched 1.5 to 8 times; and
maps of 32 x 32 to 48 x 48 heights, smooth ones that are not Gaussian, with kinks and steps, and tapered ones
like measured ones. The truth is the limit over 16, 24 and 32 points per shortest wave (with effects 24, 32
and 48), whose own interval counts, too.

Run as ``python tests/benchmarks/accuracy_coverage.py [elastic | hardness | thickness | coating | graded |
stretched | smooth | kinked | measured | all] [cases] [first seed]``; 100 elastic cases take about a minute.
"""

from __future__ import annotations

import math
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import area_cases
import numpy as np

from fem_contact import contact_areas
from fem_contact.area import EDGE_CONSTANTS
from validation.comparison.accuracy import reach
from validation.effects.coating import Coating
from validation.effects.graded import Graded
from validation.effects.hardness import Hardness
from validation.effects.thickness import Thickness
from validation.execution.bench import Bench
from validation.execution.press import solves_of
from validation.measurements.measurement import grid_for, limit_over
from validation.scenes.problem import realise
from validation.scenes.scene import Methods, Scene
from validation.scenes.tables import FileSurface, Load, SelfAffineSurface, SolidSpec
from validation.solvers.bem import BemOptions

_TRUTH = {True: (16, 24, 32), False: (24, 32, 48)}
_WAVES = 8
_EFFECTS = ("hardness", "thickness", "coating", "graded")
_MAPS = ("smooth", "kinked", "measured")
_LENGTH = 1e-3


def _log_uniform(generator, low, high):
    return float(np.exp(generator.uniform(math.log(low), math.log(high))))


@dataclass(frozen=True, kw_only=True)
class Case:
    """A scene of one surface, and the accuracy that is asked for."""

    scene: Scene
    target: float

    @classmethod
    def drawn(cls, seed, kind, folder):
        """Draw one; a map lies in the folder."""
        generator = np.random.default_rng([seed, 20261122])
        ratio = _log_uniform(generator, 2, 8)
        periods = _log_uniform(generator, 1, min(4.0, _WAVES / ratio))
        stretch = _log_uniform(generator, 1.5, 8) if kind == "stretched" else None
        surface = SelfAffineSurface(
            kind="self-affine",
            length=(_LENGTH, _LENGTH),
            hurst=generator.uniform(0.1, 1.0),
            lambda_long=_LENGTH / max(periods, stretch or 0),
            lambda_short=_LENGTH / max(periods, stretch or 0) / ratio,
            rms_gradient=0.1,
            amplitudes=str(generator.choice(["exact", "gaussian"])),
            seed=seed,
            stretch=stretch,
        )
        load = _log_uniform(generator, 0.01, 0.6)
        effects = ()
        solid, scale = SolidSpec(young=0.91e9, poisson=0.3), 1e9 * 0.1
        if kind in _MAPS:
            surface = _mapped(seed, kind, folder, points=int(generator.integers(32, 49)))
        depth = _LENGTH * _log_uniform(generator, 0.05, 1.0)
        if kind == "hardness":
            hardness = _log_uniform(generator, 0.1, 1.5)
            effects, load = (Hardness(hardness=hardness * scale),), min(load, 0.5 * hardness)
        elif kind == "thickness":
            effects = (Thickness(thickness=depth),)
        elif kind == "coating":
            effects = (Coating(young=0.91e9 * _log_uniform(generator, 0.2, 5), thickness=depth),)
        elif kind == "graded":
            effects = (Graded(bulk_young=0.91e9 * _log_uniform(generator, 0.2, 5), depth=depth),)
        scene = Scene(
            name="drawn",
            surface=surface,
            solid=solid,
            load=Load(reduced_pressure=load),
            methods=Methods(bem=BemOptions(grids=((512, 512),))),
            effects=effects,
        )
        asked = (0.01, 0.1) if kind in _EFFECTS else (0.002, 0.05)
        return cls(scene=scene, target=_log_uniform(generator, *asked))

    def truth(self):
        """Return the limit over fine grids."""
        problem = realise(self.scene)
        grids = tuple(grid_for(problem, level) for level in _TRUTH[not self.scene.effects])
        fine = BemOptions(grids=grids, tolerance=1e-7)
        solves = solves_of(self.scene.model_copy(update={"methods": Methods(bem=fine)}), problem)
        results = [solve.do(threads=1).contact for solve in solves]
        told = {"edge_constant": EDGE_CONSTANTS["bem"], "subcell": not self.scene.effects}
        return limit_over([contact_areas(result, **told) for result in results])


def _mapped(seed, kind, folder, *, points):
    """Write a map of heights; a measured one is a window of a larger surface."""
    drawn = area_cases.Case.drawn(seed, kind="stretched" if kind == "measured" else kind)
    larger = points * 3 // 2 if kind == "measured" else points
    path = folder / f"{kind}-{seed}.npy"
    np.save(path, drawn.field(larger, (0.0, 0.0)).heights[:points, :points] * 0.1 * _LENGTH)
    edges = "tukey" if kind == "measured" else "periodic"
    return FileSurface(kind="file", path=path, length=(_LENGTH, _LENGTH), unit=1.0, edges=edges, tilt="plane")


def judged(case):
    """Return what was reached, its error in claimed half-widths, and whether the interval holds the truth."""
    with tempfile.TemporaryDirectory() as folder:
        reached = reach(case.scene, Bench.at(folder), target=case.target)
    truth = case.truth()
    half = math.hypot(reached.error * reached.area, 2 * truth.uncertainty)
    return reached, (reached.area - truth.value) / half, abs(reached.area - truth.value) <= half


def main(arguments):
    """Print each case that fails, and the share that holds."""
    kind = arguments[0] if arguments else "elastic"
    cases, first = (int(text) for text in (*arguments[1:], *("100", "7001")[len(arguments[1:]) :]))
    kinds = ("elastic", *_EFFECTS, "stretched", *_MAPS) if kind == "all" else (kind,)
    folder = Path(tempfile.mkdtemp())
    for name in kinds:
        held, distances, spent = 0, [], 0.0
        for done, seed in enumerate(range(first, first + cases), start=1):
            case = Case.drawn(seed, name, folder)
            reached, distance, holds = judged(case)
            assert reached.error <= case.target
            held, spent = held + holds, spent + reached.seconds
            distances.append(distance)
            if not holds:
                print(f"  {name} {seed}: {distance:+.2f} half-widths, asked {case.target:.2%}", flush=True)
            if done % 10 == 0 or done == cases:
                print(
                    f"{name}: {held} of {done} hold ({held / done:.1%}), mean "
                    f"{np.mean(distances):+.2f} and rms "
                    f"{np.std(distances):.2f} half-widths off, {spent / done:.2f} s each",
                    flush=True,
                )


if __name__ == "__main__":
    main(sys.argv[1:])
