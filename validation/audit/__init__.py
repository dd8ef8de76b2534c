"""The independent reader: every number of a run, computed again from its stored fields alone.

It shares no code with what it judges but the reading of files. It computes with NumPy, special functions of
SciPy and closed forms; constants stand here a second time. Nothing of `persson` and `fem_contact` is
imported, and the linter holds that.
"""

from validation.audit.ledger import Entry, Ledger
from validation.audit.reading import audit

__all__ = ["Entry", "Ledger", "audit"]
