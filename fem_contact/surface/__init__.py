"""Height fields: given ones, random ones, patches with edges, and their power spectra."""

from fem_contact.surface.heights import HeightField as HeightField
from fem_contact.surface.heights import Patch as Patch
from fem_contact.surface.random import RandomWaves as RandomWaves
from fem_contact.surface.random import random_surface as random_surface
from fem_contact.surface.random import random_waves as random_waves
from fem_contact.surface.random import resolves as resolves
from fem_contact.surface.spectra import Lay as Lay
from fem_contact.surface.spectra import RadialSpectrum as RadialSpectrum
from fem_contact.surface.spectra import Window as Window
from fem_contact.surface.spectra import estimate_spectrum as estimate_spectrum
from fem_contact.surface.spectra import measured_lay as measured_lay
from fem_contact.surface.spectra import radial_spectrum as radial_spectrum
from fem_contact.surface.spectra import window_weights as window_weights
