"""Frictionless contact of a rigid rough surface with an elastic solid, by boundary and by finite elements.

>>> import fem_contact as fc
>>> surface = fc.self_affine(
...     length="100 um", hurst=0.8, lambda_long="50 um", lambda_short="10 um", rms_gradient=0.1, seed=1
... )
>>> fc.press(surface, young="1 GPa", poisson=0.3, reduced_pressure=0.05).area
A/A0 = 0.110

The solvers themselves: `bem`, `block`, `adhesion`, `random_surface`, `HeightField`, `Solid`, ...

The public names stand in `__init__.pyi`; each is imported when first asked for.
"""

import lazy_loader

from fem_contact._environment import settle

_attribute, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

settle()


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("fem-contact")
    if name == "initial_slope":
        raise AttributeError("fem_contact.initial_slope is called window_slope: it is no limit")
    return _attribute(name)
