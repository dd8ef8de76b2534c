"""Arguments of a notebook become tables of a scene, or one line that says what to do."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
import xarray as xr
from pydantic import ValidationError
from scipy.fft import next_fast_len

from validation.arrays import Grid, Pair
from validation.comparison.fields import MAPS, with_cells
from validation.errors import SceneError, UsageError
from validation.report.marks import Figure, Image, against
from validation.report.quantities import in_prefixed_unit, labelled
from validation.scenes.mistakes import problems
from validation.units import Table

Quantity = float | str
GridLike = int | Grid
T = TypeVar("T", bound=Table)


def plain(value: Any) -> Any:
    """Return numbers and arrays of NumPy as those of Python, which tables are made of, without None.

    >>> plain({"load": np.array([0.1, 0.2]), "seed": np.int64(3)})
    {'load': [0.1, 0.2], 'seed': 3}
    """
    if hasattr(value, "magnitude") and hasattr(value, "units"):  # of pint
        sizes, unit = np.asarray(value.magnitude), f"{value.units:~}"
        return [f"{size} {unit}" for size in sizes.tolist()] if sizes.ndim else f"{sizes.item()} {unit}"
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items() if item is not None}
    return [plain(item) for item in value] if isinstance(value, (list, tuple)) else value


def checked(kind: type[T], source: str, values: Mapping[str, Any]) -> T:
    """Return a table of what was said; None counts as not said.

    Raises
    ------
    SceneError
        One line for each mistake.
    """
    try:
        return kind.model_validate(plain(values))
    except ValidationError as error:
        raise SceneError(source, problems(error)) from None


def pair(grid: GridLike) -> Grid:
    """Return a grid; one number stands for both sides."""
    sides = (grid, grid) if isinstance(grid, int) else tuple(grid) if isinstance(grid, (tuple, list)) else ()
    if len(sides) != 2 or not all(isinstance(n, int) and n > 0 for n in sides):
        raise UsageError(f"grid = {grid!r}: give points along the sides, as 256 or (256, 128)")
    return sides


def fast_grid(lengths: Pair, shortest: float, points_per_wave: float) -> Grid:
    """Return a grid of at least so many points per shortest wave, of a size that transforms quickly."""
    spacing = shortest / points_per_wave * (1 + 1e-12)
    nx, ny = (int(next_fast_len(math.ceil(length / spacing))) for length in lengths)
    return nx, ny


def shown(value: Any, unit: str = "1") -> str:
    """Write a value of a table briefly.

    >>> shown(1e-4, "m"), shown((1e-4, 2e-4)), shown("sharp")
    ('100 um', '(0.0001, 0.0002)', 'sharp')
    """
    if isinstance(value, (tuple, list)):
        return f"({', '.join(shown(item, unit) for item in value)})"
    return in_prefixed_unit(value, unit) if isinstance(value, float) else str(value)


def as_html(title: str, facts: Mapping[str, str]) -> str:
    """Return a small table of facts."""
    left = "style='text-align:left'"
    cells = ((html.escape(name), html.escape(value)) for name, value in facts.items())
    rows = (f"<tr><th {left}>{name}</th><td {left}>{value}</td></tr>" for name, value in cells)
    return f"<table><caption>{html.escape(title)}</caption>{''.join(rows)}</table>"


def on_places(data: xr.Dataset, spacing: Pair, **maps: Any) -> xr.Dataset:
    """Add maps over x and y, the middles of cells [m], to a dataset."""
    data = with_cells(data, next(iter(maps.values())).shape, spacing)
    return labelled(data.assign({name: (MAPS, values) for name, values in maps.items()}))


def map_of(name: str, caption: str, *, cmap: str = "viridis") -> Figure:
    """Declare the figure of one map."""
    panel = against("x", Image(name, rows="y", cmap=cmap))
    return Figure(name.replace("_", "-"), caption, [panel])
