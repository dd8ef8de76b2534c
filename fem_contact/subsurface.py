r"""Displacement and stress below the surface, from the pressures of a contact, one wave at a time.

A wave of pressure deforms the solid in plane strain, along its own direction and down. Its state at a depth,
y = (u_l, u_z, s_lz, s_zz), is a sum of waves that decay downwards and waves that decay upwards, one pair of
each for every homogeneous sheet of the solid. The sheets are passed twice: upwards for what the solid below
reflects, downwards for the amplitudes. Nothing grows on the way, however deep the solid.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import ArrayLike

from fem_contact._checks import room_for, samples, shown
from fem_contact._types import Array, Complex
from fem_contact.contact import ContactResult, check_result
from fem_contact.errors import InvalidInput, UnsupportedEffect
from fem_contact.response import Response, check_response
from fem_contact.settings import Settings
from fem_contact.sheets import body_of
from fem_contact.stress import von_mises
from fem_contact.surface.heights import wavevectors

#: Growth of the default depths from one to the next, and the deepest of them over the longer period.
_GROWTH, _DEEPEST = 1.25, 1.0


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
    >>> from fem_contact import HalfSpace, HeightField, Solid, bem
    >>> x = np.arange(64) / 64
    >>> wave = HeightField(heights=1e-3 * np.cos(2 * np.pi * x)[:, None] * np.ones(64), lengths=(1.0, 1.0))
    >>> half_space = HalfSpace(solid=Solid(young=1.0, poisson=0.3))
    >>> pressed = bem.solve(wave, half_space, mean_pressure=0.01)
    >>> below = fields_below(pressed, half_space, depths=[0.0, 0.1])
    >>> bool(np.allclose(below.stress[:, :, 0, 2], -pressed.pressure))
    True
    """
    fields = _Fields(contact, response, depths, threads)
    planes, shape = fields.planes, (*contact.shape, fields.planes.size)
    room_for(f"depths = {planes.size}", needed=8.0 * 12 * shape[0] * shape[1] * shape[2])
    displacement, stress = np.empty((*shape, 3)), np.empty((*shape, 6))
    for k, depth in enumerate(planes):
        plane = fields.at(float(depth))
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
    fields = _Fields(contact, response, depths, threads)
    return (fields.at(float(depth)) for depth in fields.planes)


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
    from scipy.optimize import minimize_scalar

    if depths is None:
        depths = default_depths(contact, response)[1:]
    fields = _Fields(contact, response, depths, threads)
    planes = fields.planes
    largest_at: dict[float, tuple[float, int]] = {}

    def largest(depth: float) -> float:
        if depth not in largest_at:
            values = fields.at(depth).von_mises
            place = int(np.argmax(values))
            largest_at[depth] = float(values.flat[place]), place
        return largest_at[depth][0]

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
    depth = max(largest_at, key=lambda depth: largest_at[depth][0])
    value, place = largest_at[depth]
    i, j = np.unravel_index(place, contact.shape)
    dx, dy = contact.spacing
    return Strongest(von_mises=value, depth=depth, place=(float(i * dx), float(j * dy)))


def default_depths(contact: ContactResult, response: Response) -> Array:
    """Return depths [m] that follow the fields: 0, then from half a cell down, each a quarter deeper.

    They end at the longer period, or at the base of a layer.
    """
    check_result("contact", contact)
    check_response(response)
    deepest = min(_DEEPEST * max(contact.lengths), body_of(response).base_depth)
    first = min(0.5 * min(contact.spacing), 0.5 * deepest)
    count = int(np.ceil(np.log(deepest / first) / np.log(_GROWTH)))
    # Ratios are raised to a power, not lengths, whose unit would change the last digit.
    steps = (deepest / first) ** (np.arange(count + 1) / count)
    return np.append(0.0, np.minimum(first * steps, deepest))


class _Fields:
    """The waves of one pressure, to be summed at any depth."""

    def __init__(
        self, contact: ContactResult, response: Response, depths: ArrayLike | None, threads: int | None
    ) -> None:
        check_result("contact", contact)
        check_response(response)
        if contact.weights is not None or not contact.periodic:
            raise UnsupportedEffect(
                "contact: its nodes weigh differently (quadratic elements) or its sides are free "
                "(FreeHalfSpace); take the stress of the block itself"
            )
        self.body = body_of(response)
        planes = default_depths(contact, response) if depths is None else samples("depths", depths)
        self.planes = np.array(planes)
        if planes[0] < 0 or np.any(np.diff(planes) <= 0):
            raise InvalidInput(f"depths = {shown(planes)}: must rise, and none be negative, in m")
        if planes[-1] > self.body.base_depth * (1 + 1e-12):
            raise InvalidInput(
                f"depths: the deepest, {planes[-1]:.6g} m, lies below the base of the layer, at "
                f"{self.body.base_depth:.6g} m"
            )
        self.shape = contact.shape
        self.threads = Settings(threads=threads).workers
        qx, qy = np.ix_(*wavevectors(contact.shape, contact.lengths))
        q = np.hypot(qx, qy)
        self.waves = scipy.fft.rfft2(contact.pressure, workers=self.threads)
        self.mean = contact.mean_pressure
        self.waves[0, 0] = 0
        values, places = np.unique(q, return_inverse=True)
        self.places = places - 1  # without q = 0, whose amplitude is zero
        self.places[0, 0] = 0
        self.q = values[1:]
        self.states = self.body.states(self.q) if self.q.size else None
        unit = np.where(q > 0, q, 1.0)
        self.cos2, self.sin2 = (qx / unit) ** 2, (qy / unit) ** 2
        # A wave at the Nyquist limit runs both ways at once: what is odd in it vanishes on the grid.
        self.cos, self.sin = (
            _without_nyquist(part, n) / unit for part, n in zip((qx, qy), contact.shape, strict=True)
        )

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
            waves, summed, places = self.waves, self._summed, self.places
            sideways = -1j * waves * along[places]
            displacement[..., 0] = summed(sideways * self.cos)
            displacement[..., 1] = summed(sideways * self.sin)
            displacement[..., 2] = -summed(waves * down[places])
            parallel, across = parallel[places], across[places]
            # The depth counts down and z counts up, which turns the sign of the shear.
            slanted = 1j * self.waves * shear[places]
            stress[..., 0] = summed(waves * (parallel * self.cos2 + across * self.sin2))
            stress[..., 1] = summed(waves * (parallel * self.sin2 + across * self.cos2))
            stress[..., 2] = summed(waves * normal[places])
            stress[..., 3] = summed(slanted * self.sin)
            stress[..., 4] = summed(slanted * self.cos)
            stress[..., 5] = summed(waves * (parallel - across) * self.cos * self.sin)
        displacement[..., 2] -= rest * self.body.sunk(depth)
        stress[..., :2] -= rest * nu / (1 - nu)
        stress[..., 2] -= rest
        return AtDepth(depth=depth, displacement=displacement, stress=stress)

    def _summed(self, waves: Complex) -> Array:
        return scipy.fft.irfft2(waves, s=self.shape, workers=self.threads)


def _without_nyquist(q: Array, points: int) -> Array:
    """Wavevectors of one axis, 0 at the Nyquist limit of an even number of points."""
    inside = np.array(q)
    if points % 2 == 0:
        inside[np.abs(inside) == np.abs(inside).max()] = 0
    return inside
