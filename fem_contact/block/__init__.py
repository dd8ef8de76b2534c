"""The finite-element block: an elastic slab of hexahedra, pressed by a rigid rough surface."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
