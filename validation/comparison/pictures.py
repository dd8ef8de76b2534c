"""3-D pictures for a report: rendered off screen from stored solves where that works, a word where not."""

from __future__ import annotations

import tempfile
from pathlib import Path

from validation.execution.pool import Worker
from validation.report.page import Picture

_PATIENCE = 120


def render_stored(solve: Path, *, label: str) -> tuple[Picture | None, str]:
    """Return a picture of the deformed surface of a stored solve, or None and the reason why there is none.

    It is done in a process of its own: without a display or a graphics driver the renderer may not only fail
    but take its process with it.
    """
    with tempfile.TemporaryDirectory() as folder, Worker() as worker:
        image = Path(folder) / "surface-3d.png"
        try:
            worker.call(_render, solve, image, seconds=_PATIENCE)
        except Exception as error:  # its own, or that of the process it takes with it
            return None, f"off-screen rendering does not work here: {error}{worker.last_words()}"
        png = image.read_bytes()
    caption = (
        f"The deformed surface of the elastic body ({label}), coloured by contact pressure: dark is high, "
        "light is low. Displacements are magnified so that the deepest dent is a tenth of the period."
    )
    return Picture(name="surface-3d", png=png, caption=caption), ""


def _render(solve: Path, image: Path) -> None:
    from fem_contact.export import render_surface
    from validation.execution.store import read_result

    # The renderer chooses the format by the suffix.
    render_surface(image, read_result(solve))
