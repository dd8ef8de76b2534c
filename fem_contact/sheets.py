"""Homogeneous sheets under a wave of pressure: the waves in them, and their state at a depth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fem_contact._types import Array
from fem_contact.errors import UnsupportedEffect
from fem_contact.graded import MIRROR, TABULATED, ExponentialSolid, LayeredSolid, plane_waves, upwards
from fem_contact.response import BondedLayer, FrictionlessLayer, HalfSpace, Response
from fem_contact.solid import Solid


def body_of(response: Response) -> Layered | Exponential:
    """Return the sheets of a solid."""
    if isinstance(response, HalfSpace):
        return Layered(solids=(response.solid,), thicknesses=(np.inf,))
    if isinstance(response, BondedLayer | FrictionlessLayer):
        base = "bonded" if isinstance(response, BondedLayer) else "frictionless"
        return Layered(solids=(response.solid,), thicknesses=(response.thickness,), base=base)
    if isinstance(response, LayeredSolid):
        return Layered(solids=(*response.layers, response.base), thicknesses=(*response.thicknesses, np.inf))
    if isinstance(response, ExponentialSolid):
        return Exponential(solid=response)
    raise UnsupportedEffect(
        f"response = {type(response).__name__}: only its surface is known; give a half-space, a layer, a "
        "layered or an exponential solid"
    )


@dataclass(frozen=True, kw_only=True)
class Sheets:
    """Homogeneous sheets under waves of number q, and the amplitudes of the waves in them."""

    q: Array  # (n,): |q| [1/m]
    tops: Array  # (k, n): Depths at which they begin [m], from 0
    thicknesses: Array  # (k, n): [m]; that of a half-space, the last, is infinite
    shear: Array  # (k, n): Moduli G [Pa]
    poisson: Array  # (k,)
    # (k, n, 2): Amplitudes times q per pressure: of what decays downwards from the top, upwards from
    # the bottom.
    down: Array
    up: Array

    @classmethod
    def under_pressure(
        cls, q: Array, *, thicknesses: Array, shear: Array, poisson: Array, base: str
    ) -> Sheets:
        """Solve for the amplitudes under a wave of unit pressure, without shear at the surface.

        Upwards goes what sheets reflect. Downwards the uppermost sheet bears the pressure, and each other one
        moves at its top as the one above does at its bottom.
        """
        count = len(thicknesses)
        stack = [*upwards(q, thicknesses=thicknesses, shear=shear, poisson=poisson, base=base)][::-1]
        reflection, tops = np.stack([sheet[0] for sheet in stack]), [sheet[1] for sheet in stack]
        down_waves = np.empty((count, q.size, 2))
        down_waves[0] = np.linalg.solve(tops[0][1], np.broadcast_to([[0.0], [-1.0]], (q.size, 2, 1)))[..., 0]
        for k in range(count - 1):
            at_bottom = _state(
                poisson[k],
                shear[k],
                q * thicknesses[k],
                remaining=0 * q,
                down=down_waves[k],
                up=(reflection[k] @ down_waves[k][..., None])[..., 0],
            )[:, :2]
            down_waves[k + 1] = np.linalg.solve(tops[k + 1][0], at_bottom[..., None])[..., 0]
        edges = np.cumsum(thicknesses[:-1], axis=0)
        return cls(
            q=q,
            tops=np.concatenate([np.zeros((1, q.size)), edges]),
            thicknesses=thicknesses,
            shear=shear,
            poisson=poisson,
            down=down_waves,
            up=(reflection @ down_waves[..., None])[..., 0],
        )

    def at(self, depth: float) -> Array:
        """Return q u_l, q u_z, s_lz and s_zz per pressure at a depth, (n, 4)."""
        # At the border of two sheets the upper one counts.
        sheet = np.maximum(np.count_nonzero(self.tops < depth, axis=0) - 1, 0)
        one = np.arange(self.q.size)
        thickness, below = self.thicknesses[sheet, one], depth - self.tops[sheet, one]
        left = np.where(np.isfinite(thickness), np.maximum(thickness - below, 0), 0.0)
        return _state(
            self.poisson[sheet],
            self.shear[sheet, one],
            self.q * below,
            remaining=self.q * left,
            down=self.down[sheet, one],
            up=self.up[sheet, one],
        )


def _state(
    poisson: float | Array, shear: Array, x: Array, *, remaining: Array, down: Array, up: Array
) -> Array:
    """Return q u_l, q u_z, s_lz, s_zz at the scaled depth x in a sheet, and `remaining` above its bottom."""
    fall, rise = np.exp(-x)[:, None] * down, np.exp(-remaining)[:, None] * up
    parts = zip(plane_waves(poisson, x), plane_waves(poisson, remaining), (MIRROR, -MIRROR), strict=True)
    displacement, stress = (
        (falling @ fall[..., None] + sign @ rising @ rise[..., None])[..., 0]
        for falling, rising, sign in parts
    )
    return np.concatenate([displacement, stress * shear[:, None]], axis=-1)


@dataclass(frozen=True, kw_only=True)
class Layered:
    """A solid of homogeneous layers."""

    solids: tuple[Solid, ...]
    thicknesses: tuple[float, ...]
    base: str = "half-space"

    @property
    def base_depth(self) -> float:
        """Depth of the rigid base [m]."""
        return float(sum(self.thicknesses))

    def states(self, q: Array) -> Sheets:
        """Return what gives the state of each wave at a depth."""
        across = np.ones(q.size)
        return Sheets.under_pressure(
            q,
            thicknesses=np.multiply.outer(np.array(self.thicknesses), across),
            shear=np.multiply.outer([solid.shear_modulus for solid in self.solids], across),
            poisson=np.array([solid.poisson for solid in self.solids]),
            base=self.base,
        )

    def solid_at(self, depth: float) -> Solid:
        """Return the solid at a depth; at a border the upper one."""
        edges = np.cumsum(self.thicknesses)
        return self.solids[int(np.count_nonzero(edges[:-1] < depth))]

    def sunk(self, depth: float) -> float:
        """Displacement into the solid per mean pressure [m/Pa], from the base or else from the surface."""
        tops = np.append(0.0, np.cumsum(self.thicknesses)[:-1])
        within = np.clip(depth - tops, 0, self.thicknesses)
        if np.isfinite(self.base_depth):
            within = within - np.array(self.thicknesses)
        return -float(sum(part / _confined(solid) for part, solid in zip(within, self.solids, strict=True)))


@dataclass(frozen=True, kw_only=True)
class Exponential:
    """A modulus that relaxes exponentially with depth, by the sublayers of its response."""

    solid: ExponentialSolid
    base_depth: float = np.inf

    def states(self, q: Array) -> Sheets | Splined:
        """Return what gives the state of each wave at a depth."""
        if q.size <= TABULATED:
            return self._sheets(q)
        return Splined(q=q, table=self._sheets(np.geomspace(q.min(), q.max(), TABULATED)))

    def _sheets(self, q: Array) -> Sheets:
        return Sheets.under_pressure(q, **self.solid.sheets(q), base="half-space")

    def solid_at(self, depth: float) -> Solid:
        """Return the solid at a depth."""
        young = float(self.solid.young(np.array(depth)))
        return Solid(young=young, poisson=self.solid.surface.poisson)

    def sunk(self, depth: float) -> float:
        """Displacement into the solid per mean pressure [m/Pa], relative to the surface."""
        bulk = Solid(young=self.solid.bulk_young, poisson=self.solid.surface.poisson)
        # The integral of 1/E(z), in closed form.
        ratio = self.solid_at(depth).young / self.solid.surface.young
        return -(depth + self.solid.depth * float(np.log(ratio))) / _confined(bulk)


@dataclass(frozen=True, kw_only=True)
class Splined:
    """States of many waves from a spline through those of fewer."""

    q: Array
    table: Sheets

    def at(self, depth: float) -> Array:
        """Return the state at a depth, (n, 4)."""
        from scipy.interpolate import CubicSpline

        # Without its exponential the state varies slowly with q.
        nodes = np.log(self.table.q)
        bare = self.table.at(depth) * np.exp(np.minimum(self.table.q * depth, 600.0))[:, None]
        return CubicSpline(nodes, bare)(np.log(self.q)) * np.exp(-self.q * depth)[:, None]


def _confined(solid: Solid) -> float:
    """Modulus [Pa] of compression without sideways strain; infinite at nu = 1/2."""
    nu = solid.poisson
    return solid.young * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) if nu < 0.5 else np.inf
