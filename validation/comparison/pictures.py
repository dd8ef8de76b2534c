"""3-D pictures for a report: rendered off screen from stored solves where that works, a word where not."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from validation.report.page import Picture

_PATIENCE = 120


def render_stored(solve: Path, *, label: str) -> tuple[Picture | None, str]:
    """Return a picture of the deformed surface of a stored solve, or None and the reason why there is none.

    It is done in a process of its own: without a display or a graphics driver the renderer may not only fail
    but take its process with it.
    """
    path = [entry for entry in sys.path if entry]
    code = f"import sys; sys.path[:0] = {path!r}; from validation.comparison.pictures import _main; _main()"
    with tempfile.TemporaryDirectory() as folder:
        image = Path(folder) / "surface-3d.png"
        command = [sys.executable, "-c", code, str(solve), str(image)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=_PATIENCE, check=False)
        except subprocess.TimeoutExpired:
            return None, f"off-screen rendering took more than {_PATIENCE} s"
        if done.returncode or not image.exists():
            last = done.stderr.strip().splitlines()[-1:] or [f"it ended with {done.returncode}"]
            return None, f"off-screen rendering does not work here ({last[0][:200]})"
        png = image.read_bytes()
    caption = (
        f"The deformed surface of the elastic body ({label}), coloured by contact pressure: dark is high, "
        "light is low. Displacements are magnified so that the deepest dent is a tenth of the period."
    )
    return Picture(name="surface-3d", png=png, caption=caption), ""


def _main() -> None:
    from fem_contact.export import render_surface
    from validation.execution.store import read_result

    # The renderer chooses the format by the suffix.
    render_surface(Path(sys.argv[2]), read_result(Path(sys.argv[1])))
