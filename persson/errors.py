"""The exceptions of :mod:`persson`; every message says what was found, what is allowed and what to do."""


class PerssonError(Exception):
    """Anything the theory refuses or fails to do."""


class InvalidInput(PerssonError, ValueError):
    """An argument that no computation can start from."""


class OutsideTheory(InvalidInput):
    """A case for which the equations have no admissible solution; the message gives the reason."""


class NotConverged(PerssonError, RuntimeError):
    """A result was asked for as final although its error estimate exceeds what was asked for."""
