"""One adhesive contact reduced to numbers: area, force and stress in it, and its elastic energy wave by wave."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from persson.adhesion import AdhesiveContact, Interface, solve_adhesion
from persson.errors import PerssonError
from persson.scale import Scale
from validation.arrays import Array
from validation.measures.single_solve import SingleSolve, Takes
from validation.scenes.realised import Realised

if TYPE_CHECKING:
    import xarray as xr

    from fem_contact.contact import ContactResult

__all__ = ["STRESS_EDGES", "StickyContact", "adhesive_theory"]

#: Edges of the bins of sigma / (E* h'_rms) in the contact; what lies outside counts in the first or last bin.
STRESS_EDGES = np.linspace(-3.0, 5.0, 321)

#: Work of adhesion over the elastic energy of full contact below which a contact is not parted from there.
_HOLDS = 1e-3


def adhesive_theory(
    realised: Realised,
    *,
    work: float,
    energy: Literal["improved", "old"],
    area: Literal["star", "projected"] = "star",
    hardness: float | None = None,
) -> AdhesiveContact | None:
    """Solve the theory with adhesion for the gradient of one surface; None where it has no answer."""
    spectrum = realised.spectrum_shape
    scaled = spectrum.scaled(float(realised.field.rms_gradient**2 / spectrum.m2()))
    try:
        return solve_adhesion(
            Scale(scaled, contact_modulus=realised.contact_modulus),
            pressure=realised.pressure,
            interface=Interface(work_of_adhesion=work, energy=energy, area=area),
            yield_stress=hardness,
        ).checked()
    except PerssonError:
        return None


@dataclass(frozen=True, kw_only=True)
class StickyContact(SingleSolve):
    """One surface with attraction (exponential law), approached from the contact without it, and parted from full contact.

    Attributes
    ----------
    work, reach : float
        w [J/m^2] and range [m] of the attraction.
    shells : tuple of float
        Wavevectors [1/m], rising, between which the elastic energy is summed.
    """

    kind, words = "sticky", "adhesion"
    version = 1
    takes = Takes(seconds=0.05, each_point=1.2e-5, bytes=400)  # some 500 pairs of transforms

    work: float
    reach: float
    shells: tuple[float, ...]

    def measure(self) -> xr.Dataset:
        """Solve without attraction, then with it from there and from full contact."""
        import xarray as xr

        from fem_contact import adhesion, bem

        field, law = self.heights(), adhesion.Exponential(work=self.work, reach=self.reach)
        told: dict[str, Any] = {"mean_pressure": self.realised.pressure, "threads": 1}
        plain = bem.solve(field, self.half_space, **told).checked()
        told["law"] = law
        near = adhesion.solve(field, self.half_space, start=np.maximum(plain.gap, 0.0), **told)
        contact = near.contact.checked()
        inside = contact.in_contact
        stress = contact.pressure[inside] / self.realised.pressure_scale
        shares, _ = np.histogram(np.clip(stress, STRESS_EDGES[0], STRESS_EDGES[-1]), bins=STRESS_EDGES)
        found = {
            "area": float(inside.mean()),
            "plain": float(plain.in_contact.mean()),
            "force": float(np.mean(contact.pressure * inside)) / self.realised.pressure,
            "tension": float(np.mean(stress < 0)) if stress.size else 0.0,
            "gap": float(contact.gap.mean()) / self.realised.field.rms_height,
        }
        full = self._by_shell(contact.heights)
        found["parted"] = np.nan
        # Hardly any attraction is a long way from full contact, and holds nothing there.
        if self.work > _HOLDS * full.sum():
            start = np.zeros(field.shape)
            parted = adhesion.solve(field, self.half_space, start=start, **told).contact.checked()
            found["parted"] = float(parted.in_contact.mean())
        return xr.Dataset(
            {name: ((), value) for name, value in found.items()}
            | {
                "stress": ("stress_bin", shares / inside.size),
                "stored": ("shell", self._by_shell(contact.displacement)),
                "full": ("shell", full),
                "stored_by_pressure": ((), _stored(contact)),
            }
        )

    def _by_shell(self, displacement: Array) -> Array:
        """Elastic energy [J/m^2] of the waves up to each of `shells` and beyond the last, sum E* q |u|^2 / 4."""
        field = self.heights()
        nx, ny = field.shape
        qx, qy = (2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(field.shape, field.spacing, strict=True))
        q = np.hypot(qx[:, None], qy[None, :])
        power = np.abs(np.fft.fft2(displacement) / (nx * ny)) ** 2
        edges = np.array(self.shells) * (1 + 1e-9)
        energy = self.realised.contact_modulus / 4 * (q * power).ravel()
        shell = np.searchsorted(edges, q.ravel())
        return np.asarray(np.bincount(shell, weights=energy, minlength=edges.size + 1), dtype=float)


def _stored(contact: ContactResult) -> float:
    """Elastic energy per nominal area [J/m^2], half of p u without their means."""
    pressure, displacement = contact.pressure, contact.displacement
    return 0.5 * float(np.mean((pressure - pressure.mean()) * (displacement - displacement.mean())))
