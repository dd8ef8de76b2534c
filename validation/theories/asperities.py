"""Sums over independent summits: Bush, Gibson and Thomas, Greenwood Williamson, Carbone, Bottiglione."""

import math

import numpy as np

from persson.asperities import bush_gibson_thomas, nayak_asperities
from persson.elastic import KAPPA_BGT
from persson.errors import InvalidInput
from validation.arrays import Array
from validation.theories.base import Rough, Theory

#: Separations over h_rms between which pressures are sought, and how many.
_SEPARATIONS = (-4.0, 7.0, 240)


class BushGibsonThomas(Theory):
    """Bush, Gibson and Thomas (1975) at vanishing load: A/A0 = sqrt(2 pi) p0 / (E* h'_rms), while below 1."""

    name = "bush-gibson-thomas"
    label = "Bush, Gibson, Thomas 1975"
    papers = ("[bush1975].",)

    def area(self, pressure: Array, rough: Rough) -> Array:
        """Return the linear law."""
        line = KAPPA_BGT * np.asarray(pressure) / (rough.contact_modulus * rough.moments.rms_gradient)
        return np.where(line < 1, line, np.nan)


class CarboneBottiglione(Theory):
    """The same summits at any load: Carbone and Bottiglione (2008) on how soon the linear law is left."""

    name = "carbone-bottiglione"
    label = "Carbone, Bottiglione 2008"
    papers = ("[carbone2008].", "[bush1975].")

    def _table(self, rough: Rough) -> tuple[Array, Array, Array]:
        """Return separations that fall, and the pressures and areas that they lead to."""
        distance = np.linspace(*_SEPARATIONS)[::-1] * rough.moments.rms_height
        contact = bush_gibson_thomas(distance, moments=rough.moments, contact_modulus=rough.contact_modulus)
        return distance, contact.pressure, contact.area

    def area(self, pressure: Array, rough: Rough) -> Array:
        """Return A/A0, interpolated between separations."""
        _, pressures, areas = self._table(rough)
        log = np.interp(np.log(pressure), np.log(pressures), np.log(areas), left=math.nan, right=math.nan)
        return np.where(np.exp(log) < 1, np.exp(log), np.nan)

    def mean_gap(self, pressure: Array, rough: Rough) -> Array:
        """Return the distance of the plane from the mean plane: nothing moves between summits."""
        distance, pressures, _ = self._table(rough)
        return np.interp(np.log(pressure), np.log(pressures), distance, left=math.nan, right=math.nan)


class GreenwoodWilliamson(Theory):
    """Greenwood and Williamson (1966), with the density, mean curvature and scatter of Nayak's summits."""

    name = "greenwood-williamson"
    label = "Greenwood, Williamson 1966"
    papers = ("[greenwood1966].",)

    def area(self, pressure: Array, rough: Rough) -> Array:
        """Return A/A0; NaN where no separation carries the load."""
        summits = nayak_asperities(rough.moments)
        values = np.full(np.shape(pressure), np.nan)
        for k, load in enumerate(np.asarray(pressure)):
            try:
                values[k] = summits.contact_at(float(load), contact_modulus=rough.contact_modulus).area
            except InvalidInput:
                continue
        return np.where(values < 1, values, np.nan)
