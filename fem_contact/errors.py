"""The exceptions of :mod:`fem_contact`; every message says what was found, what is allowed and what to do."""


class FemContactError(Exception):
    """Anything this package refuses or fails to do."""


class InvalidInput(FemContactError, ValueError):
    """An argument that no computation can start from."""


class UnsupportedEffect(InvalidInput):
    """A physical effect that the chosen solver does not handle; it is refused, never ignored."""


class InsufficientMemory(FemContactError, MemoryError):
    """The estimate made before starting exceeds the memory that is available."""


class NotConverged(FemContactError, RuntimeError):
    """A result was asked for as final although its solver did not converge."""
