"""A figure with the numbers behind it and a caption, written as SVG, PDF, CSV and netCDF."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from validation.files import atomic_path

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Drawing", "Written", "write_drawings"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawing:
    """One figure of a report.

    Attributes
    ----------
    name : str
        Names its files.
    figure : matplotlib.figure.Figure
    data : xarray.Dataset
        Every number that is drawn, with units.
    caption : str
        What is seen, in words.
    """

    name: str
    figure: Figure
    data: xr.Dataset
    caption: str


@dataclass(frozen=True, kw_only=True)
class Written:
    """A figure on disk, as a report embeds it."""

    name: str
    svg: Any
    caption: str
    files: tuple[str, ...]


def write_drawings(drawings: Sequence[Drawing], folder: Path) -> tuple[Written, ...]:
    """Write figures and their data into `folder`/figures; return what a report embeds."""
    from markupsafe import Markup

    from validation import plots

    target = folder / "figures"
    target.mkdir(exist_ok=True)
    written = []
    for drawing in drawings:
        paths = {suffix: target / f"{drawing.name}.{suffix}" for suffix in ("svg", "pdf", "csv", "nc")}
        for suffix in ("svg", "pdf"):
            with atomic_path(paths[suffix]) as draft:
                plots.save_figure(drawing.figure, draft)
        with atomic_path(paths["csv"]) as draft:
            drawing.data.to_dataframe().reset_index().to_csv(draft, index=False)
        with atomic_path(paths["nc"]) as draft:
            drawing.data.to_netcdf(draft, engine="netcdf4")
        text = paths["svg"].read_text(encoding="utf-8")
        # This package drew it: nothing in it comes from elsewhere.
        svg = Markup(plots.embeddable(text, drawing.name))
        files = tuple(f"figures/{path.name}" for path in paths.values())
        written.append(Written(name=drawing.name, svg=svg, caption=drawing.caption, files=files))
    return tuple(written)
