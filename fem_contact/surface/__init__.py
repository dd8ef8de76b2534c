"""Height fields: given ones, random ones, patches with edges, and their power spectra."""

from fem_contact.surface.heights import HeightField, Patch
from fem_contact.surface.random import RandomWaves, random_surface, random_waves, resolves
from fem_contact.surface.spectra import (
    Lay,
    RadialSpectrum,
    Window,
    estimate_spectrum,
    measured_lay,
    radial_spectrum,
    window_weights,
)

__all__ = [
    "HeightField",
    "Lay",
    "Patch",
    "RadialSpectrum",
    "RandomWaves",
    "Window",
    "estimate_spectrum",
    "measured_lay",
    "radial_spectrum",
    "random_surface",
    "random_waves",
    "resolves",
    "window_weights",
]
