"""A figure with the numbers behind it and a caption, written as SVG, PDF, CSV and netCDF."""

from __future__ import annotations

import html
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from validation.files import atomic_path
from validation.report.table import write_dataset

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawn:
    """One thing that was drawn: artist, axes, mark, and the slice it shows."""

    artist: Any
    axes: Any
    mark: Any
    x: str
    data: xr.Dataset
    label: str
    factors: tuple[float, float]
    look: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False)
class Drawing:
    """One figure of a report, called as its files: what is drawn, every number in it, and a caption."""

    name: str
    figure: Figure
    data: xr.Dataset
    caption: str
    drawn: tuple[Drawn, ...] = ()

    def _repr_html_(self) -> str:
        from validation.report.figure import embeddable, save_figure

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "figure.svg"
            save_figure(self.figure, path)
            svg = embeddable(path.read_text(encoding="utf-8"), self.name, words=self.caption)
        return f"<figure>{svg}<figcaption>{html.escape(self.caption)}</figcaption></figure>"


def write_drawing(drawing: Drawing, folder: Path) -> tuple[Path, ...]:
    """Write a figure and its data into a folder; return the files, SVG first."""
    import netCDF4
    from xarray.backends import NetCDF4DataStore

    from validation.report.figure import save_figure

    svg, pdf, table, data = (folder / f"{drawing.name}.{suffix}" for suffix in ("svg", "pdf", "csv", "nc"))
    for path in (svg, pdf):
        with atomic_path(path) as draft:
            save_figure(drawing.figure, draft)
    tables = write_dataset(drawing.data, table)
    # Its own `to_netcdf` imports Dask for it, which takes as long as a figure.
    with atomic_path(data) as draft, netCDF4.Dataset(draft, "w") as file:
        drawing.data.dump_to_store(NetCDF4DataStore(file))  # type: ignore[no-untyped-call]
    return (svg, pdf, *tables, data)
