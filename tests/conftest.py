"""Settings shared by all tests: reproducible property tests, and no window ever opened."""

import os
import sys

from hypothesis import settings

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")

# Hundreds of processes import the same modules, and share their bytecode. Under -B nobody does: the bytecode
# of before would pass for a module with a planted fault.
if "-B" not in sys.orig_argv:
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False

# No deadline: the first call of a compiled kernel pays for its compilation. Derandomised: a red test is red
# for everybody; `--hypothesis-profile=explore` looks for new examples.
settings.register_profile("reproducible", deadline=None, derandomize=True, max_examples=50, print_blob=True)
settings.register_profile("explore", deadline=None, max_examples=1000, print_blob=True)
settings.load_profile("reproducible")
