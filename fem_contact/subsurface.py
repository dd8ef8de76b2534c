r"""Displacement and stress below the surface, from the pressures of a contact, one wave at a time.

A wave of pressure deforms the solid in plane strain, along its own direction and down. Its state at a depth,
y = (u_l, u_z, s_lz, s_zz), is a sum of waves that decay downwards and waves that decay upwards, one pair of
each for every homogeneous sheet of the solid. The sheets are passed twice: upwards for what the solid below
reflects, downwards for the amplitudes. Nothing grows on the way, however deep the solid.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize_scalar

from fem_contact._checks import room_for, samples, shown
from fem_contact.contact import ContactResult, check_result
from fem_contact.errors import InvalidInput, UnsupportedEffect
from fem_contact.graded import MIRROR, ExponentialSolid, LayeredSolid, plane_waves
from fem_contact.response import BondedLayer, FrictionlessLayer, HalfSpace, Response, check_response
from fem_contact.settings import available_processors
from fem_contact.solid import Solid
from fem_contact.stress import von_mises

__all__ = [
    "AtDepth",
    "Strongest",
    "Subsurface",
    "default_depths",
    "fields_below",
    "planes_below",
    "strongest_point",
]

Array = NDArray[np.float64]

#: Growth of the default depths from one to the next, and the deepest of them over the longer period.
_GROWTH, _DEEPEST = 1.25, 1.0

#: Waves of a modulus that varies continuously: beyond this number a spline goes through so many.
_TABULATED = 512


@dataclass(frozen=True, kw_only=True)
class AtDepth:
    """Fields on one plane below the surface.

    Attributes
    ----------
    depth : float
        Distance from the surface [m].
    displacement : (nx, ny, 3) array
        u_x, u_y, u_z [m]; u_z is positive upwards, out of the solid.
    stress : (nx, ny, 6) array
        Components xx, yy, zz, yz, xz, xy [Pa], tension positive.
    """

    depth: float
    displacement: Array
    stress: Array

    @property
    def von_mises(self) -> Array:
        """Von Mises stress [Pa], (nx, ny)."""
        return von_mises(self.stress)


@dataclass(frozen=True, kw_only=True, eq=False)
class Subsurface:
    """Displacement and stress on several planes below a contact.

    Attributes
    ----------
    depths : (nz,) array
        Distances from the surface [m], rising.
    displacement : (nx, ny, nz, 3) array
        u_x, u_y, u_z [m]; u_z is positive upwards, out of the solid.
    stress : (nx, ny, nz, 6) array
        Components xx, yy, zz, yz, xz, xy [Pa], tension positive.
    contact : ContactResult
        Whose pressures these are.
    """

    depths: Array
    displacement: Array
    stress: Array
    contact: ContactResult

    @property
    def von_mises(self) -> Array:
        """Von Mises stress [Pa], (nx, ny, nz)."""
        return von_mises(self.stress)


@dataclass(frozen=True, kw_only=True)
class Strongest:
    """Where a solid is strained most: it yields there first.

    Attributes
    ----------
    von_mises : float
        Largest von Mises stress [Pa].
    depth : float
        Its distance from the surface [m].
    place : (float, float)
        x and y of the grid point above it [m].
    """

    von_mises: float
    depth: float
    place: tuple[float, float]


def fields_below(
    contact: ContactResult, response: Response, *, depths: ArrayLike | None = None, threads: int | None = None
) -> Subsurface:
    r"""Find displacement and stress below a contact.

    Below a half-space, for a wave exp(iqx) of pressure p at depth z,

    .. math::
        \sigma_{zz} = -p\,(1 + qz)\,e^{-qz}, \quad \sigma_{xx} = -p\,(1 - qz)\,e^{-qz}, \quad
        \sigma_{xz} = -i p\,qz\,e^{-qz}, \quad \sigma_{yy} = \nu (\sigma_{xx} + \sigma_{zz})

    Parameters
    ----------
    contact : ContactResult
        Of a method whose points all weigh alike; with hardness or adhesion its pressures are taken as they
        are, and the solid below as elastic.
    response : Response
        The solid that was pressed: `HalfSpace`, `BondedLayer`, `FrictionlessLayer`, `LayeredSolid` or
        `ExponentialSolid`.
    depths : sequence of float, optional
        Distances from the surface [m], rising, none negative; `default_depths` if not given. At the border of
        two layers the fields are those of the upper one.
    threads : int, optional
        Of each transform; all available processors if not given.

    Raises
    ------
    InvalidInput
        For depths that do not rise, or lie below the base of a layer.
    UnsupportedEffect
        For a response of which only the surface is known, and for points that weigh differently.
    InsufficientMemory
        If the fields do not fit; `planes_below` holds one plane at a time.

    Notes
    -----
    K. L. Johnson, Contact Mechanics (1985), Secs. 2.2 and 13.2; layers as in `LayeredSolid`. Pressures are
    those of the trigonometric interpolant through the grid points, as the boundary elements have them: near
    the surface (depths below a cell) the edges of the contact ring, deeper down they do not.

    The mean pressure compresses the solid without sideways strain, the period being given: s_xx = s_yy =
    - nu/(1 - nu) p0. The displacement is counted from the mean surface of a half-space, and from the base of
    a layer.

    Examples
    --------
    >>> from fem_contact import HeightField, bem
    >>> x = np.arange(64) / 64
    >>> wave = HeightField(heights=1e-3 * np.cos(2 * np.pi * x)[:, None] * np.ones(64), lengths=(1.0, 1.0))
    >>> half_space = HalfSpace(solid=Solid(young=1.0, poisson=0.3))
    >>> pressed = bem.solve(wave, half_space, mean_pressure=0.01)
    >>> below = fields_below(pressed, half_space, depths=[0.0, 0.1])
    >>> bool(np.allclose(below.stress[:, :, 0, 2], -pressed.pressure))
    True
    """
    body, planes = _checked(contact, response, depths)
    shape = (*contact.shape, planes.size)
    room_for("depths", planes.size, needed=8.0 * 12 * shape[0] * shape[1] * shape[2])
    displacement, stress = np.empty((*shape, 3)), np.empty((*shape, 6))
    for k, plane in enumerate(_layers(contact, body, planes, threads)):
        displacement[:, :, k], stress[:, :, k] = plane.displacement, plane.stress
    for array in (planes, displacement, stress):
        array.setflags(write=False)
    return Subsurface(depths=planes, displacement=displacement, stress=stress, contact=contact)


def planes_below(
    contact: ContactResult, response: Response, *, depths: ArrayLike | None = None, threads: int | None = None
) -> Iterator[AtDepth]:
    """Yield the planes of `fields_below` one by one, for grids whose fields do not fit into memory.

    Parameters and errors are those of `fields_below`.
    """
    body, planes = _checked(contact, response, depths)
    return _layers(contact, body, planes, threads)


def strongest_point(
    contact: ContactResult, response: Response, *, depths: ArrayLike | None = None, threads: int | None = None
) -> Strongest:
    """Find the largest von Mises stress below a contact, and its depth.

    The given depths are searched, and then the interval around the best of them, to 1e-3 of its depth. The
    surface itself is left out unless it is among the depths: there the edges of a contact ring.

    Parameters
    ----------
    contact, response, threads
        As in `fields_below`.
    depths : sequence of float, optional
        Distances from the surface [m] to search; those of `default_depths` below the surface if not given.

    Raises
    ------
    InvalidInput, UnsupportedEffect
        As `fields_below`.
    """
    if depths is None:
        check_result("contact", contact)
        check_response(response)
        depths = default_depths(contact, response)[1:]
    body, planes = _checked(contact, response, depths)
    fields = _Fields(contact, body, threads)
    found: dict[float, tuple[float, int]] = {}

    def largest(depth: float) -> float:
        if depth not in found:
            values = fields.at(depth).von_mises
            place = int(np.argmax(values))
            found[depth] = float(values.flat[place]), place
        return found[depth][0]

    best = max(range(planes.size), key=lambda k: largest(float(planes[k])))
    low, high = planes[max(best - 1, 0)], planes[min(best + 1, planes.size - 1)]
    unit = float(planes[best] or high)
    if high > low:
        minimize_scalar(
            lambda ratio: -largest(float(unit * ratio)),
            bounds=(low / unit, high / unit),
            method="bounded",
            options={"xatol": 1e-3},
        )
    depth = max(found, key=lambda depth: found[depth][0])
    value, place = found[depth]
    i, j = np.unravel_index(place, contact.shape)
    dx, dy = contact.spacing
    return Strongest(von_mises=value, depth=depth, place=(float(i * dx), float(j * dy)))


def default_depths(contact: ContactResult, response: Response) -> Array:
    """Return depths [m] that follow the fields: 0, then from half a cell down, each a quarter deeper.

    They end at the longer period, or at the base of a layer.
    """
    check_result("contact", contact)
    check_response(response)
    deepest = min(_DEEPEST * max(contact.lengths), _body(response).base_depth)
    first = min(0.5 * min(contact.spacing), 0.5 * deepest)
    count = int(np.ceil(np.log(deepest / first) / np.log(_GROWTH)))
    # Ratios are raised to a power, not lengths, whose unit would change the last digit.
    steps = (deepest / first) ** (np.arange(count + 1) / count)
    return np.concatenate([[0.0], np.minimum(first * steps, deepest)])


def _checked(
    contact: ContactResult, response: Response, depths: ArrayLike | None
) -> tuple[_Layered | _Exponential, Array]:
    """Refuse what has no fields below the surface, and return the body and the depths."""
    check_result("contact", contact)
    check_response(response)
    if contact.weights is not None:
        raise UnsupportedEffect(
            "contact: its nodes weigh differently (quadratic elements); take the stress of the block itself"
        )
    body = _body(response)
    planes = default_depths(contact, response) if depths is None else samples("depths", depths, unit="m")
    planes = np.array(planes)
    if planes[0] < 0 or np.any(np.diff(planes) <= 0):
        raise InvalidInput(f"depths = {shown(planes)}: must rise, and none be negative, in m")
    if planes[-1] > body.base_depth * (1 + 1e-12):
        raise InvalidInput(
            f"depths: the deepest, {planes[-1]:.6g} m, lies below the base of the layer, at "
            f"{body.base_depth:.6g} m"
        )
    return body, planes


def _layers(
    contact: ContactResult, body: _Layered | _Exponential, planes: Array, threads: int | None
) -> Iterator[AtDepth]:
    fields = _Fields(contact, body, threads)
    for depth in planes:
        yield fields.at(float(depth))


def _body(response: Response) -> _Layered | _Exponential:
    """Return the sheets of a solid."""
    if isinstance(response, HalfSpace):
        return _Layered(solids=(response.solid,), thicknesses=(np.inf,))
    if isinstance(response, BondedLayer | FrictionlessLayer):
        base = "bonded" if isinstance(response, BondedLayer) else "frictionless"
        return _Layered(solids=(response.solid,), thicknesses=(response.thickness,), base=base)
    if isinstance(response, LayeredSolid):
        return _Layered(solids=(*response.layers, response.base), thicknesses=(*response.thicknesses, np.inf))
    if isinstance(response, ExponentialSolid):
        return _Exponential(solid=response)
    raise UnsupportedEffect(
        f"response = {type(response).__name__}: only its surface is known; give a half-space, a layer, a "
        "layered or an exponential solid"
    )


@dataclass(frozen=True, kw_only=True)
class _Sheets:
    """Homogeneous sheets under waves of number q, and the amplitudes of the waves in them.

    Attributes
    ----------
    q : (n,) array
        |q| [1/m].
    tops : (k, n) array
        Depths at which they begin [m], from 0.
    thicknesses : (k, n) array
        [m]; that of a half-space, the last, is infinite.
    shear : (k, n) array
        Moduli G [Pa].
    poisson : (k,) array
    down, up : (k, n, 2) arrays
        Amplitudes times q per pressure: of what decays downwards from the top, upwards from the bottom.
    """

    q: Array
    tops: Array
    thicknesses: Array
    shear: Array
    poisson: Array
    down: Array
    up: Array

    @classmethod
    def under_pressure(
        cls, q: Array, *, thicknesses: Array, shear: Array, poisson: Array, base: str
    ) -> _Sheets:
        """Solve for the amplitudes under a wave of unit pressure, without shear at the surface.

        Upwards: what a sheet reflects, R, follows from the condition A u + B s = 0 at its bottom; its
        impedance is that condition, -Z u + s = 0, for the sheet above. Downwards: the uppermost sheet bears
        the pressure, and each other one moves at its top as the one above does at its bottom.
        """
        count = len(thicknesses)
        identity, free = np.eye(2), np.zeros((2, 2))
        bonded, sliding = (identity, free), (np.diag([0.0, 1.0]), np.diag([1.0, 0.0]))
        condition = sliding if base == "frictionless" else bonded
        # Half-spaces reflect nothing.
        reflection = np.zeros((count, q.size, 2, 2))
        tops: list[tuple[Array, Array]] = [(identity, identity)] * count
        for k in reversed(range(count)):
            across, nu, modulus = q * thicknesses[k], poisson[k], shear[k]
            if np.all(np.isfinite(across)):
                down, up = _waves(nu, modulus, across), _mirrored(nu, modulus, 0 * across)
                down_missed, up_missed = (condition[0] @ u + condition[1] @ s for u, s in (down, up))
                reflection[k] = -np.linalg.solve(up_missed, down_missed) * np.exp(-across)[:, None, None]
                tops[k] = _at_top(nu, modulus, across, reflection[k])
            else:
                tops[k] = _waves(nu, modulus, 0 * q)
            displacement, stress = tops[k]
            impedance = np.swapaxes(np.linalg.solve(_t(displacement), _t(stress)), -1, -2)
            condition = (-impedance, identity)
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


def _waves(poisson: float, shear: Array, x: Array) -> tuple[Array, Array]:
    """Displacement and stress over q of waves that decay downwards, without exp(-x), (n, 2, 2) each."""
    displacement, stress = plane_waves(poisson, x)
    return displacement, stress * shear[:, None, None]


def _mirrored(poisson: float, shear: Array, x: Array) -> tuple[Array, Array]:
    """Those of waves that decay upwards."""
    displacement, stress = _waves(poisson, shear, x)
    return MIRROR @ displacement, -MIRROR @ stress


def _at_top(poisson: float, shear: Array, across: Array, reflection: Array) -> tuple[Array, Array]:
    """Displacement and stress at the top of a sheet, per amplitude of what decays downwards."""
    decayed = reflection * np.exp(-across)[:, None, None]
    down, up = _waves(poisson, shear, 0 * across), _mirrored(poisson, shear, across)
    return down[0] + up[0] @ decayed, down[1] + up[1] @ decayed


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


def _t(matrix: Array) -> Array:
    return np.swapaxes(matrix, -1, -2)


@dataclass(frozen=True, kw_only=True)
class _Layered:
    """A solid of homogeneous layers."""

    solids: tuple[Solid, ...]
    thicknesses: tuple[float, ...]
    base: str = "half-space"

    @property
    def base_depth(self) -> float:
        """Depth of the rigid base [m]."""
        return float(sum(self.thicknesses))

    def sheets(self, q: Array) -> _Sheets:
        """Return the amplitudes in every layer."""
        across = np.ones(q.size)
        return _Sheets.under_pressure(
            q,
            thicknesses=np.multiply.outer(np.array(self.thicknesses), across),
            shear=np.multiply.outer([solid.shear_modulus for solid in self.solids], across),
            poisson=np.array([solid.poisson for solid in self.solids]),
            base=self.base,
        )

    def states(self, q: Array) -> _Sheets:
        """Return what gives the state of each wave at a depth."""
        return self.sheets(q)

    def solid_at(self, depth: float) -> Solid:
        """Return the solid at a depth; at a border the upper one."""
        edges = np.cumsum(self.thicknesses)
        return self.solids[int(np.count_nonzero(edges[:-1] < depth))]

    def sunk(self, depth: float) -> float:
        """Displacement into the solid per mean pressure [m/Pa], relative to the surface or to the base."""
        tops = np.concatenate([[0.0], np.cumsum(self.thicknesses)[:-1]])
        within = np.clip(depth - tops, 0, self.thicknesses)
        if np.isfinite(self.base_depth):
            within = within - np.array(self.thicknesses)
        return -float(sum(part / _confined(solid) for part, solid in zip(within, self.solids, strict=True)))


@dataclass(frozen=True, kw_only=True)
class _Exponential:
    """A modulus that relaxes exponentially with depth, by the sublayers of its response."""

    solid: ExponentialSolid
    base_depth: float = np.inf

    def states(self, q: Array) -> _Sheets | _Splined:
        """Return what gives the state of each wave at a depth."""
        if q.size <= _TABULATED:
            return self._sheets(q)
        return _Splined(q=q, table=self._sheets(np.geomspace(q.min(), q.max(), _TABULATED)))

    def _sheets(self, q: Array) -> _Sheets:
        edges = self.solid.sublayer_edges(q)
        middles = (edges[1:] + edges[:-1]) / 2
        nu = self.solid.surface.poisson
        thicknesses = np.diff(edges, axis=0)
        deepest = np.concatenate([self.solid.young(middles), self.solid.young(edges[-1:])])
        return _Sheets.under_pressure(
            q,
            thicknesses=np.concatenate([thicknesses, np.full((1, q.size), np.inf)]),
            shear=deepest / (2 * (1 + nu)),
            poisson=np.full(len(deepest), nu),
            base="half-space",
        )

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
class _Splined:
    """States of many waves from a spline through those of fewer."""

    q: Array
    table: _Sheets

    def at(self, depth: float) -> Array:
        """Return the state at a depth, (n, 4)."""
        from scipy.interpolate import CubicSpline

        # Without its exponential the state varies slowly with q.
        nodes = np.log(self.table.q)
        bare = self.table.at(depth) * np.exp(np.minimum(self.table.q * depth, 600.0))[:, None]
        return np.asarray(CubicSpline(nodes, bare)(np.log(self.q)) * np.exp(-self.q * depth)[:, None])


def _confined(solid: Solid) -> float:
    """Modulus [Pa] of compression without sideways strain; infinite at nu = 1/2."""
    nu = solid.poisson
    return solid.young * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) if nu < 0.5 else np.inf


class _Fields:
    """The waves of one pressure, to be summed at any depth."""

    def __init__(self, contact: ContactResult, body: _Layered | _Exponential, threads: int | None) -> None:
        self.body, self.shape = body, contact.shape
        self.threads = available_processors() if threads is None else threads
        (nx, ny), (dx, dy) = contact.shape, contact.spacing
        qx = 2 * np.pi * scipy.fft.fftfreq(nx, dx)[:, None]
        qy = 2 * np.pi * scipy.fft.rfftfreq(ny, dy)[None, :]
        q = np.hypot(qx, qy)
        self.waves = scipy.fft.rfft2(contact.pressure, workers=self.threads)
        self.mean = contact.mean_pressure
        self.waves[0, 0] = 0
        values, places = np.unique(q, return_inverse=True)
        self.places = places.reshape(q.shape) - 1  # without q = 0, whose amplitude is zero
        self.places[0, 0] = 0
        self.q = values[1:]
        self.states = body.states(self.q) if self.q.size else None
        unit = np.where(q > 0, q, 1.0)
        self.cos2, self.sin2 = (qx / unit) ** 2, (qy / unit) ** 2
        # A wave at the Nyquist limit runs both ways at once: what is odd in it vanishes on the grid.
        self.cos, self.sin = _without_nyquist(qx, nx) / unit, _without_nyquist(qy, ny) / unit

    def at(self, depth: float) -> AtDepth:
        """Sum the waves at one depth, and the mean."""
        solid = self.body.solid_at(depth)
        nu, rest = solid.poisson, self.mean
        displacement, stress = np.zeros((*self.shape, 3)), np.zeros((*self.shape, 6))
        if self.states is not None:
            state = self.states.at(depth)
            along, down = (part / self.q for part in state.T[:2])
            shear, normal = state.T[2:]
            parallel = (2 * solid.shear_modulus * state.T[0] + nu * normal) / (1 - nu)
            across = nu * (parallel + normal)
            self._put(displacement, along=along, down=down)
            self._put_stress(stress, parallel=parallel, across=across, normal=normal, shear=shear)
        displacement[..., 2] -= rest * self.body.sunk(depth)
        stress[..., :2] -= rest * nu / (1 - nu)
        stress[..., 2] -= rest
        return AtDepth(depth=depth, displacement=displacement, stress=stress)

    def _put(self, displacement: Array, *, along: Array, down: Array) -> None:
        sideways = -1j * self.waves * along[self.places]
        displacement[..., 0] = self._summed(sideways * self.cos)
        displacement[..., 1] = self._summed(sideways * self.sin)
        displacement[..., 2] = -self._summed(self.waves * down[self.places])

    def _put_stress(
        self, stress: Array, *, parallel: Array, across: Array, normal: Array, shear: Array
    ) -> None:
        parallel, across = parallel[self.places], across[self.places]
        # The depth counts down and z counts up, which turns the sign of the shear.
        slanted = 1j * self.waves * shear[self.places]
        stress[..., 0] = self._summed(self.waves * (parallel * self.cos2 + across * self.sin2))
        stress[..., 1] = self._summed(self.waves * (parallel * self.sin2 + across * self.cos2))
        stress[..., 2] = self._summed(self.waves * normal[self.places])
        stress[..., 3] = self._summed(slanted * self.sin)
        stress[..., 4] = self._summed(slanted * self.cos)
        stress[..., 5] = self._summed(self.waves * (parallel - across) * self.cos * self.sin)

    def _summed(self, waves: NDArray[np.complex128]) -> Array:
        return np.asarray(scipy.fft.irfft2(waves, s=self.shape, workers=self.threads))


def _without_nyquist(q: Array, points: int) -> Array:
    """Wavevectors of one axis, 0 at the Nyquist limit of an even number of points."""
    kept = np.array(q)
    if points % 2 == 0:
        kept[np.abs(kept) == np.abs(kept).max()] = 0
    return kept
