"""What a surface tells about its contact without a solve: slopes on its summits, the pressure of full contact, moments."""

from __future__ import annotations

import time

import numpy as np
import scipy.fft
import xarray as xr

from fem_contact.surface import HeightField
from fem_contact.surface.heights import wavevectors
from validation.arrays import Array, Grid
from validation.execution.measurement import measurement
from validation.scenes.problem import ContactProblem

#: Shares of the nominal area, for the highest heights and the highest pressures of full contact.
_SHARES = (0.01, 0.03, 0.1, 0.3)
#: p* at which the tension of full contact is read off.
_LOADS = (0.1, 0.2, 0.4, 0.8, 1.5)


def unsolved_statistics(field: HeightField) -> dict[str, float]:
    """Return statistics that the contact area of a surface follows, each the mean of h and -h.

    Of the highest heights, of shares of the nominal area: mean height, slope^2 and full-contact pressure on
    them; the same of the highest full-contact pressures; share and mean of the tension of full contact at
    some loads; fourth moments. Heights, slopes and pressures are divided by their rms. The contact area of
    a surface with few waves is larger than the mean where its summits are less steep than the rest.
    """
    height, slope, pressure = _unit_fields(field)
    statistics: dict[str, float] = {}
    counts = [max(1, round(share * height.size)) for share in _SHARES]
    parts = [*counts, *(height.size - count for count in counts)]
    for name, key in (("height", height), ("pressure", pressure)):
        order = np.argpartition(key, parts)
        for of, values, sign in (("height", height, -1), ("slope", slope, 1), ("pressure", pressure, -1)):
            sorted_by = values[order]
            for share, count in zip(_SHARES, counts, strict=True):
                mean = (sorted_by[-count:].mean() + sign * sorted_by[:count].mean()) / 2
                statistics[f"{of} on the top {share:g} of {name}"] = float(mean)
    for load in _LOADS:
        # The variance of the pressure at full contact is (E* h'_rms)^2 / 4.
        raised = pressure + 2 * load, -pressure + 2 * load
        statistics[f"tension at {load:g}"] = float(np.mean([np.minimum(p, 0).mean() for p in raised]))
        statistics[f"share in tension at {load:g}"] = float(np.mean([(p < 0).mean() for p in raised]))
    h2, p2, hp = height**2, pressure**2, height * pressure
    moments = {
        "hp": hp, "h4": h2 * h2, "p4": p2 * p2, "h2 p2": h2 * p2, "h3 p": h2 * hp, "h p3": hp * p2,
        "s4": slope**2, "h2 s2": h2 * slope, "p2 s2": p2 * slope, "h p s2": hp * slope,
    }  # fmt: skip
    return statistics | {name: float(values.mean()) for name, values in moments.items()}


def _unit_fields(field: HeightField) -> tuple[Array, Array, Array]:
    shape = field.shape
    waves = scipy.fft.rfft2(field.heights - field.heights.mean())
    qx, qy = np.ix_(*wavevectors(shape, field.lengths))
    along_x, along_y = (scipy.fft.irfft2(1j * q * waves, s=shape) for q in (qx, qy))
    slope = along_x**2 + along_y**2
    height, pressure = (scipy.fft.irfft2(w, s=shape).ravel() for w in (waves, np.hypot(qx, qy) * waves))
    return height / height.std(), (slope / slope.mean()).ravel(), pressure / pressure.std()


@measurement(
    "unsolved-{grid[0]}x{grid[1]}",
    kind="UnsolvedPairs",
    words="what {count} surfaces tell without a contact,",
    version=2,
    recipe=lambda made, problem, first, grid: made | problem.further(first).recipe | {"grid": list(grid)},
    left_out=("load", "first", "points"),
    # Five transforms and two sorts for each.
    seconds=lambda points, count: count * (5e-3 + 2e-7 * points),
    bytes=200,
    compiled=lambda: (),
)
def unsolved_pairs(*, problem: ContactProblem, grid: Grid, first: int, count: int) -> xr.Dataset:
    """Return `unsolved_statistics` of `count` surfaces of one spectrum; dimensions (surface, statistic).

    And h'_rms: where amplitudes are random it says what one pressure for all is in p*.
    """
    began = time.process_time()
    fields = (problem.further(k).heights(grid) for k in range(first, first + count))
    statistics = [unsolved_statistics(field) | {"h'_rms": field.rms_gradient} for field in fields]
    return xr.Dataset(
        {"value": (("surface", "statistic"), np.array([list(row.values()) for row in statistics]))},
        # Not a coordinate: to read one of text, xarray loads dask.
        attrs={"seconds": time.process_time() - began, "statistics": "; ".join(statistics[0])},
    )
