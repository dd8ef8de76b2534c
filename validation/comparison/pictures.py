"""3-D pictures for a report: rendered off screen from stored solves where that works, a word where not."""

from __future__ import annotations

import base64
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from validation.files import atomic_path

__all__ = ["Picture", "Pictures", "render_stored"]

_PATIENCE = 120


@dataclass(frozen=True, kw_only=True)
class Picture:
    """An image as a data URI, and what it shows."""

    data: str
    caption: str


@dataclass(frozen=True, kw_only=True)
class Pictures:
    """Images, or the reason why there are none."""

    images: tuple[Picture, ...] = ()
    missing: str = ""


def render_stored(solve: Path, target: Path, *, label: str) -> Pictures:
    """Render the deformed surface of a stored solve into `target`, a PNG file.

    It is done in a process of its own: without a display or a graphics driver the renderer may not only fail
    but take its process with it.
    """
    path = [entry for entry in sys.path if entry]
    code = f"import sys; sys.path[:0] = {path!r}; from validation.comparison.pictures import _main; _main()"
    command = [sys.executable, "-c", code, str(solve)]
    with tempfile.TemporaryDirectory() as folder:
        image = Path(folder) / target.name
        try:
            done = subprocess.run(
                [*command, str(image)], capture_output=True, text=True, timeout=_PATIENCE, check=False
            )
        except subprocess.TimeoutExpired:
            return Pictures(missing=f"off-screen rendering took more than {_PATIENCE} s")
        if done.returncode or not image.exists():
            last = done.stderr.strip().splitlines()[-1:] or [f"it ended with {done.returncode}"]
            return Pictures(missing=f"off-screen rendering does not work here ({last[0][:200]})")
        drawn = image.read_bytes()
    with atomic_path(target) as draft:
        draft.write_bytes(drawn)
    data = base64.b64encode(drawn).decode("ascii")
    caption = (
        f"The deformed surface of the elastic body ({label}), coloured by contact pressure: dark is low, "
        "light is "
        "high. Displacements are magnified so that the deepest dent is a tenth of the period."
    )
    return Pictures(images=(Picture(data=f"data:image/png;base64,{data}", caption=caption),))


def _main() -> None:
    from fem_contact.export import render_surface
    from validation.solves.fields import read_result

    # Drawing asks for the contact alone, whichever solver it came from.
    solution: Any = SimpleNamespace(contact=read_result(Path(sys.argv[1])))
    # The renderer chooses the format by the suffix.
    render_surface(Path(sys.argv[2]), solution)
