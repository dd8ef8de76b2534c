"""Arguments of a notebook become tables of a scene, or one line that says what to do."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError
from scipy.fft import next_fast_len

from validation.errors import SceneError
from validation.scenes.mistakes import problems
from validation.units import Table

__all__ = ["GridLike", "Quantity", "as_html", "checked", "fast_grid", "pair", "plain", "shown"]

Quantity = float | str
GridLike = int | tuple[int, int]
T = TypeVar("T", bound=Table)


def plain(value: Any) -> Any:
    """Return numbers and arrays of NumPy as those of Python, which tables are made of.

    >>> plain({"load": np.array([0.1, 0.2]), "seed": np.int64(3)})
    {'load': [0.1, 0.2], 'seed': 3}
    """
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


def checked(kind: type[T], source: str, said: Mapping[str, Any]) -> T:
    """Return a table of what was said; what is None was not.

    Raises
    ------
    SceneError
        One line for each mistake.
    """
    try:
        return kind.model_validate({name: plain(value) for name, value in said.items() if value is not None})
    except ValidationError as error:
        raise SceneError(source, problems(error)) from None


def pair(grid: GridLike) -> tuple[int, int]:
    """Return a grid; one number stands for both sides."""
    return (grid, grid) if isinstance(grid, int) else grid


def fast_grid(lengths: tuple[float, float], shortest: float, points_per_wave: float) -> tuple[int, int]:
    """Return a grid of at least so many points per shortest wave, of a size that transforms quickly."""
    spacing = shortest / points_per_wave * (1 + 1e-12)
    nx, ny = (int(next_fast_len(math.ceil(length / spacing))) for length in lengths)
    return nx, ny


def shown(value: Any) -> str:
    """Write a value of a table briefly.

    >>> shown(1e-4), shown((1e-4, 2e-4)), shown("sharp")
    ('0.0001', '(0.0001, 0.0002)', 'sharp')
    """
    if isinstance(value, (tuple, list)):
        return f"({', '.join(map(shown, value))})"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def as_html(title: str, facts: Mapping[str, str]) -> str:
    """Return a small table of facts."""
    rows = "".join(
        f"<tr><th style='text-align:left'>{html.escape(name)}</th>"
        f"<td style='text-align:left'>{html.escape(value)}</td></tr>"
        for name, value in facts.items()
    )
    return f"<table><caption>{html.escape(title)}</caption>{rows}</table>"
