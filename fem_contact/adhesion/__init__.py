"""Adhesive contact by boundary elements: laws of the gap, single states and histories of loads.

`laws` say how two surfaces attract each other, `descent` goes downhill in the energy of the gap, `state`
finds one equilibrium, `path` follows equilibria through a history of loads with its jumps.
"""

from fem_contact.adhesion.laws import Dugdale as Dugdale
from fem_contact.adhesion.laws import Exponential as Exponential
from fem_contact.adhesion.laws import GapLaw as GapLaw
from fem_contact.adhesion.path import AdhesionPath as AdhesionPath
from fem_contact.adhesion.path import Jump as Jump
from fem_contact.adhesion.path import PathPoint as PathPoint
from fem_contact.adhesion.path import follow as follow
from fem_contact.adhesion.state import CELLS_NEEDED as CELLS_NEEDED
from fem_contact.adhesion.state import AdhesiveContact as AdhesiveContact
from fem_contact.adhesion.state import Stability as Stability
from fem_contact.adhesion.state import cells_in_process_zone as cells_in_process_zone
from fem_contact.adhesion.state import solve as solve
from fem_contact.adhesion.state import stability as stability
