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

__all__ = ["Drawing", "Written", "frames", "write_csv", "write_drawings"]


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


def frames(data: xr.Dataset) -> dict[tuple[str, ...], Any]:
    """Return one data frame for each set of dimensions: together they would be multiplied out."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for name, variable in data.data_vars.items():
        if variable.dims:
            groups.setdefault(tuple(map(str, variable.dims)), []).append(str(name))
    return {
        dimensions: data[names].to_dataframe().reset_index()[[*dimensions, *names]]
        for dimensions, names in groups.items()
    }


def write_csv(data: xr.Dataset, path: Path) -> tuple[Path, ...]:
    """Write a dataset as CSV; variables of other dimensions than the first go into files of their own."""
    written = []
    for k, (dimensions, frame) in enumerate(frames(data).items()):
        target = path if k == 0 else path.with_stem(f"{path.stem}-{'-'.join(dimensions)}")
        with atomic_path(target) as draft:
            frame.to_csv(draft, index=False)
        written.append(target)
    return tuple(written)


def write_drawings(drawings: Sequence[Drawing], folder: Path) -> tuple[Written, ...]:
    """Write figures and their data into `folder`/figures; return what a report embeds."""
    from markupsafe import Markup

    from validation.report.figure import embeddable, save_figure

    target = folder / "figures"
    target.mkdir(exist_ok=True)
    written = []
    for drawing in drawings:
        paths = {suffix: target / f"{drawing.name}.{suffix}" for suffix in ("svg", "pdf", "csv", "nc")}
        for suffix in ("svg", "pdf"):
            with atomic_path(paths[suffix]) as draft:
                save_figure(drawing.figure, draft)
            # Laid out once; doing it again for the second format would cost as much as drawing.
            drawing.figure.set_layout_engine("none")
        write_csv(drawing.data, paths["csv"])
        with atomic_path(paths["nc"]) as draft:
            drawing.data.to_netcdf(draft, engine="netcdf4")
        text = paths["svg"].read_text(encoding="utf-8")
        # This package drew it: nothing in it comes from elsewhere.
        svg = Markup(embeddable(text, drawing.name))
        files = tuple(f"figures/{path.name}" for path in paths.values())
        written.append(Written(name=drawing.name, svg=svg, caption=drawing.caption, files=files))
    return tuple(written)
