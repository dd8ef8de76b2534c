r"""Solids whose modulus varies with depth: the compliance of a wave of pressure, per wavevector.

A wave exp(i q x) of pressure deforms the solid in plane strain. With x scaled by 1/q, the state of a depth is
y = (u_x, u_z, s_xz, s_zz), displacements and stresses, and equilibrium is a linear system dy/dz = M(z) y.
Passed upwards is not y, which would hold growing and decaying parts of any ratio, but the impedance Z that
ties stress to displacement, s = Z u: it stays of order one however deep or stiff the solid.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fem_contact._checks import array, instance, listed, positive_fields, positives, whole
from fem_contact._types import Array
from fem_contact.errors import InvalidInput
from fem_contact.response import wave_size
from fem_contact.solid import Solid


@dataclass(frozen=True, kw_only=True)
class LayeredSolid:
    """Homogeneous layers, bonded to each other, on a half-space: exact.

    Parameters
    ----------
    layers : sequence of Solid
        From the surface down.
    thicknesses : sequence of float
        Of each layer [m], positive.
    base : Solid
        The half-space below. Its infinite response at q = 0 is left out, and so is the layers'.

    Raises
    ------
    InvalidInput
        Unless there is one thickness for each layer, all positive and finite.

    Notes
    -----
    The layer matrix is applied to the impedance in the form of two waves, one decaying down and one decaying
    up, neither of which overflows; incompressible solids are allowed.

    Examples
    --------
    >>> soft, hard = Solid(young=1.0, poisson=0.3), Solid(young=10.0, poisson=0.3)
    >>> coated = LayeredSolid(layers=[soft], thicknesses=[1.0], base=hard)
    >>> q = np.array([1e-6, 1e3])
    >>> stiffness = 2 / (q * coated.compliance(q, 0 * q))
    >>> np.round(stiffness * (1 - 0.3**2), 4)
    array([10.,  1.])
    """

    layers: Sequence[Solid]
    thicknesses: Sequence[float]
    base: Solid

    def __post_init__(self) -> None:
        listed("layers", self.layers, Solid, what="`Solid`s")
        thicknesses = positives("thicknesses", self.thicknesses)
        instance("base", self.base, Solid)
        if len(self.layers) != len(thicknesses):
            raise InvalidInput(
                f"{len(thicknesses)} thicknesses for {len(self.layers)} layers: give one for each"
            )

    @property
    def contact_modulus(self) -> float:
        """E* [Pa] of the material at the surface, which sets the scale of the shortest waves."""
        return (self.layers[0] if self.layers else self.base).contact_modulus

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Return C(q) [m/Pa], 0 at q = 0."""
        return _on_distinct(wave_size(qx, qy), self._compliance)

    def _compliance(self, q: Array) -> Array:
        solids = (*self.layers, self.base)
        return sheet_compliance(
            q,
            thicknesses=np.array([*self.thicknesses, np.inf]),
            shear=np.array([solid.shear_modulus for solid in solids]),
            poisson=np.array([solid.poisson for solid in solids]),
        )


@dataclass(frozen=True, kw_only=True)
class ExponentialSolid:
    r"""A modulus that relaxes exponentially with depth: E(z) = E_inf + (E_0 - E_inf) exp(-z / d).

    Parameters
    ----------
    surface : Solid
        E_0 and nu, which is that of all depths.
    bulk_young : float
        E_inf [Pa].
    depth : float
        d [m].
    sublayers : int
        Homogeneous layers that stand for the profile, per wave: each carries the harmonic mean of its moduli.
        The error falls with the square of their number; of 64 it is 4e-4 to 1e-2 where the solid is
        incompressible and its bulk more than a hundred times stiffer.

    Raises
    ------
    InvalidInput
        For a modulus or depth that is not positive and finite, or less than 4 sublayers.
    """

    surface: Solid
    bulk_young: float
    depth: float
    sublayers: int = 64

    def __post_init__(self) -> None:
        instance("surface", self.surface, Solid)
        positive_fields(self, "bulk_young", "depth")
        whole("sublayers", self.sublayers, least=4, most=10_000)

    @property
    def contact_modulus(self) -> float:
        """E* [Pa] of the material at the surface."""
        return self.surface.contact_modulus

    def young(self, depth: Array) -> Array:
        """Return E(z) [Pa] at depths [m]."""
        z = array("depth", depth)
        if np.any(z < 0):
            raise InvalidInput(f"depth = {float(np.min(z))!r}: must not be negative, in m")
        return self._young(z)

    def _young(self, depth: Array) -> Array:
        return self.bulk_young + (self.surface.young - self.bulk_young) * np.exp(-depth / self.depth)

    def compliance(self, qx: Array, qy: Array) -> Array:
        """Return C(q) [m/Pa], 0 at q = 0."""
        return _on_distinct(wave_size(qx, qy), self._smooth)

    def _smooth(self, q: Array) -> Array:
        """Compliance of many waves, from a spline through q C(q) of fewer."""
        if q.size <= TABULATED:
            return self._compliance(q)
        from scipy.interpolate import CubicSpline

        # The spline's error, (step / 10)^4 or so, is far below that of the sublayers.
        place = np.log(q / q[0])
        nodes = np.linspace(0.0, place[-1], TABULATED)
        table = q[0] * np.exp(nodes)
        return CubicSpline(nodes, table * self._compliance(table))(place) / q

    def sheets(self, q: Array) -> dict[str, Array]:
        """Return the sublayers for waves [1/m] and the bulk below, as `upwards` takes them."""
        # What lies below 30 / (1/d + q) is bulk, or out of reach of the wave. Depths are denser near the
        # surface: equal steps of 1 - exp(-z / s) with s = 3 / (1/d + q).
        steps, nu = np.linspace(0, 1, self.sublayers + 1), self.surface.poisson
        edges = -3 * np.log1p(-steps * (1 - np.exp(-10.0)))[:, None] / (1 / self.depth + q)
        # Int dz / E from the surface: each carries the harmonic mean of E, for a soft skin gives way alone.
        softness = edges + self.depth * np.log(self._young(edges) / self.surface.young)
        layers = self.bulk_young * np.diff(edges, axis=0) / np.diff(softness, axis=0)
        young = np.concatenate([layers, self._young(edges[-1:])])
        return {
            "thicknesses": np.concatenate([np.diff(edges, axis=0), np.full((1, q.size), np.inf)]),
            "shear": young / (2 * (1 + nu)),
            "poisson": np.full(len(young), nu),
        }

    def _compliance(self, q: Array) -> Array:
        return sheet_compliance(q, **self.sheets(q))


#: Waves up to which every one is computed, and the number a spline goes through beyond.
TABULATED = 512


def _on_distinct(q: Array, compliance: Callable[[Array], Array]) -> Array:
    """Evaluate at the distinct |q| alone, which are far fewer than the wavevectors; 0 at q = 0."""
    values, places = np.unique(q, return_inverse=True)
    out = np.zeros(values.shape)
    # Of a wave far longer than the solar system the compliance may exceed what a number can hold.
    with np.errstate(over="ignore"):
        out[values > 0] = compliance(values[values > 0])
    return out[places]


def plane_waves(poisson: float | Array, x: Array) -> tuple[Array, Array]:
    r"""Displacements, and stresses over G q, of the two waves that decay over the scaled depth x = q z.

    Papkovich's form in plane strain, with the phase of u_x taken out: for the waves exp(-x) and x exp(-x),
    u_x = (1, x), u_z = (1, x + 3 - 4 nu), s_xz = -2 (1, x + 1 - 2 nu), s_zz = -2 (1, x + 2 - 2 nu), without
    the factor exp(-x).
    """
    nu = poisson
    one = np.ones_like(x)
    displacement = np.stack([np.stack([one, x], -1), np.stack([one, x + 3 - 4 * nu], -1)], -2)
    stress = -2 * np.stack([np.stack([one, x + 1 - 2 * nu], -1), np.stack([one, x + 2 - 2 * nu], -1)], -2)
    return displacement, stress


#: Waves that decay upwards have the same form with u_z and s_xz of the other sign.
MIRROR = np.diag([1.0, -1.0])


def waves_down(poisson: float, shear: float | Array, x: Array) -> tuple[Array, Array]:
    """Displacement and stress over q of waves that decay downwards, without exp(-x), (..., 2, 2) each."""
    displacement, stress = plane_waves(poisson, x)
    return displacement, stress * np.asarray(shear)[..., None, None]


def waves_up(poisson: float, shear: float | Array, x: Array) -> tuple[Array, Array]:
    """Those of waves that decay upwards."""
    displacement, stress = waves_down(poisson, shear, x)
    return MIRROR @ displacement, -MIRROR @ stress


def impedance_of(displacement: Array, stress: Array) -> Array:
    """Z of stress = Z displacement, for both waves."""
    turned = (np.swapaxes(part, -1, -2) for part in (displacement, stress))
    return np.swapaxes(np.linalg.solve(*turned), -1, -2)


def upwards(
    q: Array, *, thicknesses: Array, shear: Array, poisson: Array, base: str = "half-space"
) -> Iterator[tuple[Array, tuple[Array, Array]]]:
    """Yield what each sheet reflects, and displacement and stress at its top, from the lowest sheet up.

    What a sheet reflects, R, follows from the condition A u + B s = 0 at its bottom; its impedance is that
    condition, -Z u + s = 0, for the sheet above. Amplitudes come multiplied by exp(-q d) once on the way down
    and once on the way up, so that thick layers forget what is below. Half-spaces, whose thickness is
    infinite, reflect nothing.
    """
    identity, free = np.eye(2), np.zeros((2, 2))
    bonded, sliding = (identity, free), (np.diag([0.0, 1.0]), np.diag([1.0, 0.0]))
    condition = sliding if base == "frictionless" else bonded
    for k in reversed(range(len(thicknesses))):
        across, nu, modulus = q * thicknesses[k], poisson[k], shear[k]
        reflection, top = np.zeros((q.size, 2, 2)), waves_down(nu, modulus, 0 * q)
        if np.all(np.isfinite(across)):
            decay = np.exp(-across)[:, None, None]
            down, up = waves_down(nu, modulus, across), waves_up(nu, modulus, 0 * across)
            down_missed, up_missed = (condition[0] @ u + condition[1] @ s for u, s in (down, up))
            reflection = -np.linalg.solve(up_missed, down_missed) * decay
            risen = waves_up(nu, modulus, across)
            top = top[0] + risen[0] @ reflection * decay, top[1] + risen[1] @ reflection * decay
        yield reflection, top
        condition = (-impedance_of(*top), identity)


def sheet_compliance(q: Array, *, thicknesses: Array, shear: Array, poisson: Array) -> Array:
    """Displacement per pressure without shear [m/Pa] of waves [1/m] on sheets."""
    for _, top in upwards(q, thicknesses=thicknesses, shear=shear, poisson=poisson):
        surface = top
    return -np.linalg.inv(impedance_of(*surface))[:, 1, 1] / q
