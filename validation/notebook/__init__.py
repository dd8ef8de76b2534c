"""Contact of one rough surface in a few lines, for notebooks: a surface, pressed, and what is asked of it.

Nothing is computed here: tables are those of a scene, solves those of a run, numbers those of its report.

``import fem_contact as fc`` has these names.
"""

from validation.notebook._contact import Contact
from validation.notebook._pressing import press, table, theory
from validation.notebook._surface import Surface, measured, self_affine
from validation.reference import lookup as reference
from validation.studies import run as study

__all__ = ["Contact", "Surface", "measured", "press", "reference", "self_affine", "study", "table", "theory"]
