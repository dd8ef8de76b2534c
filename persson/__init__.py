"""Persson's theory of contact mechanics: functions of the power spectrum C(q), a solid and a load.

>>> from persson import SelfAffine, contact_area, elastic, stress_variance

The public names stand in `__init__.pyi`; each is imported when first asked for.
"""

import lazy_loader

_attribute, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("fem-contact")
    return _attribute(name)
