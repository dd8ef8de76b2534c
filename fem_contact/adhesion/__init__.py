"""Adhesive contact by boundary elements: laws of the gap, single states and histories of loads.

`laws` say how two surfaces attract each other, `descent` goes downhill in the energy of the gap, `state`
finds one equilibrium, `path` follows equilibria through a history of loads with its jumps.
"""

from fem_contact.adhesion.laws import Dugdale, Exponential, GapLaw
from fem_contact.adhesion.path import AdhesionPath, Jump, PathPoint, follow
from fem_contact.adhesion.state import (
    CELLS_NEEDED,
    AdhesiveContact,
    Stability,
    cells_in_process_zone,
    solve,
    stability,
)

__all__ = [
    "CELLS_NEEDED",
    "AdhesionPath",
    "AdhesiveContact",
    "Dugdale",
    "Exponential",
    "GapLaw",
    "Jump",
    "PathPoint",
    "Stability",
    "cells_in_process_zone",
    "follow",
    "solve",
    "stability",
]
