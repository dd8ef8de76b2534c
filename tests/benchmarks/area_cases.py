"""Surfaces whose contact is measured from coarse grids to fine: what is pressed, on what, and how hard.

Self-affine ones on a half-space, on elements and with every effect of a scene (`KINDS`), and others than
those that the law of error was fitted to (`SHAPES`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.fft

from fem_contact import ExponentialSolid, LayeredSolid, Solid, adhesion, bem, block
from fem_contact.response import BondedLayer, FreeHalfSpace, FrictionlessLayer, HalfSpace
from fem_contact.surface import HeightField, Patch, random_surface

#: What surfaces are pressed on.
KINDS = (
    *("elastic", "hardness", "bonded", "frictionless", "coating", "graded"),
    *("adhesion", "adhesion-hardness", "ball", "patch"),
    *("elements", "elements-hardness", "elements-layer", "elements-graded", "elements-incompressible"),
)

#: Kinds of elastic surfaces unlike those of the law, and what they are made like.
SHAPES = {
    "wide": ("self-affine",),
    "stretched": ("stretched",),
    "smooth": ("roll-off", "correlated", "ring", "exp", "sinh", "plateau", "ground", "map"),
    "kinked": ("cut", "ridge", "valley", "quantised", "sign", "pyramid", "cone", "wedge", "spheres"),
}


@dataclass(frozen=True, kw_only=True)
class Case:
    """A surface of unit rms gradient on a unit square, what it is pressed on, and how hard; E* = 1.

    Attributes
    ----------
    depth : float
        Of a layer, a coating, or over which a modulus relaxes: half the shortest to the longest wave.
    stiffness : float
        Modulus of a coating over that below it, or of a graded solid far below over that at its surface.
    work : float
        Of adhesion, over the elastic energy of full contact.
    zone : float
        Length over which adhesion acts beside an edge, over the shortest wave.
    radius : float
        Hertz's contact radius of a ball under the roughness.
    shape : str
        One of `SHAPES`.
    stretch, angle : float
        Waves are so many times as long in that direction as across.
    bend : float
        How strongly heights are transformed, or where they are cut, in h_rms.
    """

    seed: int
    kind: str
    hurst: float
    ratio: float
    periods: float
    load: float
    poisson: float = 0.0
    hardness: float | None = None
    depth: float = 0.0
    stiffness: float = 1.0
    work: float = 0.0
    zone: float = 0.0
    radius: float = 0.0
    shape: str = ""
    stretch: float = 1.0
    angle: float = 0.0
    bend: float = 0.0

    @classmethod
    def drawn(cls, seed, *, kind="elastic", waves=32):
        """Draw a spectrum of at most so many shortest waves on the period, and a load."""
        generator, further = (np.random.default_rng([seed, key]) for key in (20261122, 7))
        hurst = generator.uniform(0.1, 1.0)
        ratio = min(float(np.exp(generator.uniform(np.log(4), np.log(32)))), waves)
        most = min(4.0, waves / ratio)
        periods = float(np.exp(generator.uniform(0, np.log(most)))) if most > 1 else 1.0
        load = float(np.exp(generator.uniform(np.log(0.01), np.log(0.6))))
        told = {}

        def between(low, high):
            return float(np.exp(further.uniform(np.log(low), np.log(high))))

        if kind.startswith("elements"):
            incompressible = kind == "elements-incompressible"
            told["poisson"] = float(
                further.choice([0.49, 0.5] if incompressible else [0.0, 0.2, 0.3, 0.3, 0.4])
            )
        if kind.endswith("hardness"):
            told["hardness"] = between(0.1, 1.5)
            load = min(load, 0.5 * told["hardness"])
        if kind in ("bonded", "frictionless", "coating", "graded", "elements-layer", "elements-graded"):
            told["depth"] = between(0.5 / (periods * ratio), 1 / periods)
            told["stiffness"] = between(0.1, 10)
        if kind in ("bonded", "frictionless"):
            told["poisson"] = float(further.choice([0.0, 0.3, 0.45]))
        if kind.startswith("adhesion"):
            told |= {"work": between(0.003, 0.1), "zone": between(0.75, 3)}
        if kind == "ball":
            told["radius"] = between(0.15, 0.35)
        if kind in SHAPES:
            shape = str(further.choice(SHAPES[kind]))
            waves = between(5, 16) if kind != "wide" else between(32, 64)
            ratio = waves if kind == "smooth" else waves / between(1, min(waves / 4, 4))
            periods = waves / ratio
            told |= {"shape": shape, "bend": between(0.3, 1.2)}
            if shape in ("stretched", "ground"):
                eighths = further.choice([0, 1, 2, 4, further.uniform(0, 8)], p=[0.125] * 4 + [0.5])
                told |= {"stretch": between(1.5, 16), "angle": float(eighths) * np.pi / 8}
        return cls(seed=seed, kind=kind, hurst=hurst, ratio=ratio, periods=periods, load=load, **told)

    @property
    def located(self):
        """Whether its edges are located inside the cells."""
        return self.kind == "elastic" or self.kind in SHAPES

    @property
    def waves(self):
        """Number of shortest waves on the period."""
        return self.periods * self.ratio

    @cached_property
    def surface(self):
        """On three points per shortest wave, before heights are transformed."""
        reach = {"correlated": 1.4, "map": 2**0.5}.get(self.shape, 1.0) * self.waves
        n = 2 * int(np.ceil(1.5 * reach))
        surface = random_surface(
            lambda qx, qy: self._density(qx / (2 * np.pi), qy / (2 * np.pi)),
            q_short=2 * np.pi * reach,
            lengths=(1.0, 1.0),
            shape=(n, n),
            seed=self.seed,
            isotropic=False,
        )
        return HeightField(heights=surface.heights / surface.rms_gradient, lengths=(1.0, 1.0))

    def _density(self, x, y):
        """Power by waves on the period along x and y."""
        q, decay, waves = np.hypot(x, y), -2 - 2 * self.hurst, self.waves
        if self.shape == "correlated":
            return np.asarray(np.exp(-6 * (q / waves) ** 2))
        if self.shape == "roll-off":
            return np.asarray(np.maximum(q, waves**0.5) ** decay)
        if self.shape == "ring":
            return np.where(q >= 0.8 * waves, 1.0, 0.0)
        if self.shape == "map":
            return np.where((np.abs(x) <= waves) & (np.abs(y) <= waves), np.maximum(q, 1.0) ** decay, 0.0)
        along, across = (
            np.cos(self.angle) * x + np.sin(self.angle) * y,
            np.cos(self.angle) * y - np.sin(self.angle) * x,
        )
        bent = np.hypot(self.stretch * along, across)
        lay = np.where((bent >= 0.999 * self.periods) & (bent <= 1.001 * waves), bent**decay, 0.0)
        # Grinding leaves a little of everything else.
        return lay + 0.003 * q**decay if self.shape == "ground" else lay

    def field(self, n, shift):
        """Heights on a grid that begins at a shift."""
        if self.shape in ("pyramid", "cone", "wedge", "spheres"):
            x, y = ((np.arange(n) + part) / n for part in shift)
            return HeightField(heights=self._regular(x[:, None], y[None, :]), lengths=(1.0, 1.0))
        # Points of a grid too coarse for the waves are points of a finer one.
        finer = -(-self.surface.shape[0] // n)
        moved = self.surface.resampled((finer * n, finer * n)).shifted((finer * shift[0], finer * shift[1]))
        rms = self.surface.rms_height
        heights = self._transformed(moved.heights[::finer, ::finer] / rms) * rms
        return HeightField(heights=heights, lengths=(1.0, 1.0))

    def _transformed(self, z):
        """Heights in h_rms as the shape makes them."""
        level = 2 * self.bend - 1
        steep = 4 * self.bend
        transforms = {
            "exp": lambda: np.exp(self.bend * z),
            "sinh": lambda: np.sinh(self.bend * z),
            "plateau": lambda: -np.logaddexp(0, -steep * (z - level)) / steep,
            "cut": lambda: np.minimum(z, level),
            "ridge": lambda: -np.abs(z - level),
            "valley": lambda: np.abs(z),
            "quantised": lambda: np.round(3 * self.bend * z) / (3 * self.bend),
            "sign": lambda: np.sign(z - level),
        }
        return transforms.get(self.shape, lambda: z)()

    def _regular(self, x, y):
        """Bodies side by side, as many as long waves."""
        count = max(round(self.periods), 1)
        x, y = ((count * part + 0.3 * self.bend) % 1 - 0.5 for part in (x, y))
        wide = 0.4 * self.bend
        return {
            "pyramid": -np.maximum(np.abs(x), np.abs(y)),
            "cone": -np.minimum(np.hypot(x, y), wide),
            "wedge": -np.abs(x) + 0 * y,
            "spheres": np.sqrt(np.maximum(wide**2 - x**2 - y**2, 0.0)),
        }[self.shape] / count

    def pressed(self, level, shift):
        """Press on a grid of at least so many points per shortest wave."""
        n = 2 * scipy.fft.next_fast_len(int(np.ceil(level * self.waves / 2)), real=True)
        field = self.field(n, shift)
        solid = Solid(young=1 - self.poisson**2, poisson=self.poisson)
        if self.kind.startswith("elements"):
            depth = {"depth": self.depth} if self.kind == "elements-layer" else {}
            found = block.solve(
                field,
                solid,
                mean_pressure=self.load,
                pressure_bound=self.hardness,
                modulus=self._graded if self.kind == "elements-graded" else None,
                **depth,
            )
            return found.contact.checked()
        if self.kind.startswith("adhesion"):
            return self._attracted(field, solid)
        load = self.load
        if self.kind in ("ball", "patch"):
            field, load = self._alone(n)
        return bem.solve(
            field, self._response(solid), mean_pressure=load, pressure_bound=self.hardness, threads=1
        ).checked()

    def _graded(self, x, y, z):
        return np.asarray(self.stiffness + (1 - self.stiffness) * np.exp(z / self.depth) + 0 * (x + y))

    def _response(self, solid):
        if self.kind in ("bonded", "frictionless"):
            layer = BondedLayer if self.kind == "bonded" else FrictionlessLayer
            return layer(solid=solid, thickness=self.depth)
        if self.kind == "coating":
            base = Solid(young=1 / self.stiffness, poisson=0.0)
            return LayeredSolid(layers=[solid], thicknesses=[self.depth], base=base)
        if self.kind == "graded":
            return ExponentialSolid(surface=solid, bulk_young=self.stiffness, depth=self.depth)
        return FreeHalfSpace(solid=solid) if self.kind in ("ball", "patch") else HalfSpace(solid=solid)

    def _attracted(self, field, solid):
        work = self.work * self.surface.spectral_sum(lambda q: 0.25 * q)
        # The zone is E* w / sigma_th^2, and sigma_th is w over the reach.
        law = adhesion.Exponential(work=work, reach=float(np.sqrt(self.zone * work / self.waves)))
        found = adhesion.solve(
            field, HalfSpace(solid=solid), law=law, mean_pressure=self.load, hardness=self.hardness, threads=1
        )
        return found.contact.checked()

    def _alone(self, n):
        """Return one period with free surroundings, on a ball or flat, and what presses it."""
        middles = self.surface.resampled((n, n)).shifted((0.5, 0.5)).heights
        if self.kind == "patch":
            return Patch(heights=middles, lengths=(1.0, 1.0)), self.load
        # The reduced load is that under the ball: R = 4 E* a^3 / 3 F.
        load = self.load * np.pi * self.radius**2
        x = (np.arange(n) + 0.5) / n - 0.5
        sag = (x[:, None] ** 2 + x**2) * 3 * load / (8 * self.radius**3)
        return Patch(heights=middles - sag, lengths=(1.0, 1.0)), load
