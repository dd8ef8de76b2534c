"""Frictionless contact of a rigid rough surface with an elastic solid, by boundary and by finite elements.

>>> from fem_contact import HalfSpace, HeightField, Solid, bem, contact_areas, random_surface

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
    if name == "press":
        raise AttributeError("fem_contact.press is called fem_contact.press_yielding")
    return _attribute(name)
