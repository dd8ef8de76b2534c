"""Fresh interpreters that see what this one does."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def environment_of(*paths, **changes):
    """Variables of this process, changed; its modules, and those of further paths, can be imported."""
    path = os.pathsep.join([*map(str, paths), str(ROOT), *filter(None, sys.path)])
    return {**os.environ, "PYTHONPATH": path, **changes}


def run_python(*arguments, shell="", folder=ROOT, paths=(), **changes):
    """Run Python in a folder, after commands of the shell."""
    command = ["bash", "-c", f'{shell} exec "$0" "$@"', sys.executable, *map(str, arguments)]
    how = {"cwd": folder, "timeout": 600, "env": environment_of(*paths, **changes)}
    return subprocess.run(command, capture_output=True, text=True, check=False, **how)
