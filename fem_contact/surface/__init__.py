"""Periodic height fields: given ones, random ones, and their power spectra."""

from fem_contact.surface.heights import HeightField
from fem_contact.surface.random import random_surface, resolves
from fem_contact.surface.spectra import (
    RadialSpectrum,
    Window,
    estimate_spectrum,
    radial_spectrum,
    window_weights,
)

__all__ = [
    "HeightField",
    "RadialSpectrum",
    "Window",
    "estimate_spectrum",
    "radial_spectrum",
    "random_surface",
    "resolves",
    "window_weights",
]
