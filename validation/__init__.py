"""The comparison of theory and simulation: the only package that knows both.

What a notebook calls is best had by ``import fem_contact as fc``: fc.press, fc.self_affine, fc.study ...
"""

import lazy_loader

from fem_contact._environment import settle
from validation import _renamed  # noqa: F401  # which answers imports of old names

#: By which `fem_contact` tells it from another package of this name.
belongs_to_fem_contact = True

# Not before it is asked for: the command line needs none of it.
_attribute, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

settle()


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("fem-contact")
    return _attribute(name)
