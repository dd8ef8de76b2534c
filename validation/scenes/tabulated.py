"""A tabulated C(q): two columns of a file, and the part of it between two wavelengths."""

from __future__ import annotations

import hashlib
import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from validation.errors import UsageError
from validation.report.quantities import as_length
from validation.scenes.tables import SpectrumSurface
from validation.scenes.topography.formats import bytes_of, one_line
from validation.scenes.topography.text import read_columns

if TYPE_CHECKING:
    from persson.tabulated import Tabulated


def read_spectrum(
    path: Path, *, units: tuple[float, float] | None = None, power: str = "C"
) -> tuple[Tabulated, str]:
    """Return C(q) of a file where it is above 0, and the SHA-256 of its bytes.

    A UsageError for a file that holds no C(q).
    """
    from persson.tabulated import Tabulated

    name = f"surface.path = {str(path)!r}"
    try:
        data = bytes_of(str(path))
        table = read_columns(data)
    except OSError as error:
        raise UsageError(f"{name}: cannot be read: {one_line(error.strerror or error)}") from None
    except (UsageError, ValueError) as error:
        raise UsageError(f"{name}: is no table of q and C ({one_line(error)})") from None
    if table.shape[1] != 2:
        raise UsageError(f"{name}: must have two columns, q and C; it has {table.shape[1]}")
    for bad, words in (
        (~np.isfinite(table).all(axis=1), "must be finite"),
        (table[:, 0] <= 0, "q must be positive"),
        (np.diff(table[:, 0], prepend=-np.inf) <= 0, "q must rise from row to row"),
        (table[:, 1] < 0, "C must not be negative"),
    ):
        if bad.any():
            row = int(np.argmax(bad))
            q, c = table[row]
            raise UsageError(f"{name}: row {row + 1} has q, C = {q:g}, {c:g}; {words}")
    rough = np.flatnonzero(table[:, 1])
    if rough.size < 2 or rough.size <= rough[-1] - rough[0]:
        raise UsageError(f"{name}: C must be above 0 in two rows or more, without a gap between them")
    q, c = (table[rough] * (units or (1.0, 1.0))).T
    made = Tabulated if power == "C" else Tabulated.from_areal_psd
    return made(wavevectors=q, power=c), hashlib.sha256(data).hexdigest()


def spectrum_between(surface: SpectrumSurface) -> Tabulated:
    """Return C(q) of a surface from lambda_long to lambda_short; a UsageError beyond its table."""
    from persson.tabulated import Tabulated

    whole, _ = read_spectrum(surface.path, units=surface.units, power=surface.power)
    q, edge = whole.wavevectors, 1e-9
    low, high = 2 * math.pi / surface.lambda_long, 2 * math.pi / surface.lambda_short
    if low < q[0] * (1 - edge) or high > q[-1] * (1 + edge):
        raise UsageError(
            f"surface: waves of {as_length(surface.lambda_short)} to {as_length(surface.lambda_long)}; "
            f"the table has those of {as_length(2 * math.pi / q[-1])} to {as_length(2 * math.pi / q[0])}"
        )
    inside = (q > low * (1 + edge)) & (q < high * (1 - edge))
    q = np.concatenate([[low], q[inside], [high]])
    return Tabulated(wavevectors=q, power=whole(np.clip(q, whole.q_min, whole.q_short)))
