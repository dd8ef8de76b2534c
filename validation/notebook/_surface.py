"""Surfaces of a notebook: self-affine ones, and those that were measured."""

from __future__ import annotations

import hashlib
import html
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import xarray as xr
from pydantic import ValidationError
from scipy.fft import next_fast_len

from fem_contact.surface import HeightField, radial_spectrum
from validation.arrays import Grid, Pair
from validation.comparison.fields import MAPS, with_cells
from validation.errors import SceneError, UsageError
from validation.report.marks import Drawing, Figure, Image, against, draw
from validation.report.quantities import in_prefixed_unit, labelled
from validation.report.values import Value
from validation.scenes import surfaces
from validation.scenes.mistakes import problems
from validation.scenes.scene import sized
from validation.scenes.tables import FileSurface, SelfAffineSurface
from validation.scenes.tables import Surface as SurfaceTable
from validation.scenes.topography.measured import Measured
from validation.scenes.topography.patch import Faults, Topography
from validation.scenes.topography.raw import check_shape, real
from validation.scenes.topography.statistics import height_statistics
from validation.scenes.topography.writing import heights_over_places
from validation.units import Table, metres, sides_of, unit_of

#: Share of the largest power below which there is rounding, and no wave.
_ROUNDING = 1e-24

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Quantity = float | str
GridLike = int | Grid
T = TypeVar("T", bound=Table)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Surface:
    """A rough surface: the table of a scene, and the heights of a measured one, as they were given."""

    table: SurfaceTable
    given: Measured | None = None

    def heights(self, grid: GridLike | None = None) -> xr.DataArray:
        """Return the heights [m] over x and y [m]: on a grid, or on the smallest that resolves them."""
        field = self.field
        if grid is not None:
            given = self.given is not None
            field = field.resampled(pair(grid)) if given else surfaces.height_field(self.table, pair(grid))
        return heights_over_places(field)

    @cached_property
    def field(self) -> HeightField:
        """Heights on the smallest grid that resolves them, or as they were measured."""
        return surfaces.height_field(self.table) if self.given is None else self.given.field

    @property
    def rms_height(self) -> float:
        """h_rms [m] of the heights."""
        return self.field.rms_height

    @property
    def rms_gradient(self) -> float:
        """h'_rms of the heights, both directions together."""
        return self.field.rms_gradient

    @property
    def rms_curvature(self) -> float:
        """Half the rms of the Laplacian of the heights [1/m]."""
        return float(np.sqrt(self.field.moments[2])) / 2

    @property
    def pixel_size(self) -> Pair:
        """Steps between heights [m]."""
        return self.field.spacing

    @property
    def statistics(self) -> dict[str, Value]:
        """Kurtosis of heights and slopes, and what summits are like, by name; of a map before its taper."""
        if self.given is not None:
            self.given.check("missing")
        field = self.field if self.given is None else self.given.patch.height_field()
        traits = asdict(height_statistics(field.heights, field.spacing))
        return {name: Value(value=value, name=name) for name, value in traits.items()}

    @property
    def spectrum(self) -> xr.DataArray:
        """C(q) [m^4] of the heights, averaged over directions, over |q| [1/m]; 0 where there is no wave."""
        radial = radial_spectrum(self.field, band=surfaces.band_of(self.table))
        power = np.where(radial.power > _ROUNDING * radial.power.max(), radial.power, 0.0)
        q = ("wavevector", radial.q, {"units": "1/m", "long_name": "wave number |q|"})
        about = {"units": "m^4", "long_name": "power spectrum C(q)"}
        return xr.DataArray(power, dims="wavevector", coords={"wavevector": q}, name="C", attrs=about)

    def plot(self, *, ax: Axes | None = None) -> Drawing:
        """Draw the map of the heights; with `ax` into axes of matplotlib."""
        field, table = self.field, self.table
        if not isinstance(table, FileSurface):  # finer than it takes to resolve it
            field = surfaces.height_field(table, fast_grid(field.lengths, table.lambda_short, 8.0))
        data = on_places(xr.Dataset(), field.spacing, heights=field.heights - field.heights.mean())
        return draw(map_of("heights", "Heights of the rough surface.", cmap="gray"), data, axes=ax)

    @property
    def _facts(self) -> dict[str, str]:
        kinds = type(self.table).model_fields
        options = self.table.model_dump(exclude_none=True, exclude={"kind", "path"})
        facts = {name: shown(value, unit_of(kinds[name])) for name, value in options.items()}
        if self.given is not None:
            said = {"what was done": self.given.raw.history, "doubts": self.given.doubts}
            facts |= {name: "; ".join(words) for name, words in said.items() if words}
        return facts

    def __repr__(self) -> str:
        facts = ", ".join(f"{name}={value}" for name, value in self._facts.items())
        return f"<{self.table.kind} surface: {facts}>"

    def _repr_html_(self) -> str:
        return as_html(f"{self.table.kind} surface", self._facts)


class _Measured(Measured):
    """A measured surface of Python, where arguments mend what the table of a scene would."""

    def remedy(self, faults: Faults) -> str:
        """Say what is wrong, and which arguments mend it."""
        words = ", ".join(f'{key}="{remedy}"' for key, (_, remedy) in faults.items())
        return f": {'; '.join(why for why, _ in faults.values())}; add to measured(...): {words}"


def self_affine(
    *,
    length: Quantity | Sequence[Quantity] | None = None,
    hurst: float | None = None,
    lambda_long: Quantity | None = None,
    lambda_short: Quantity | None = None,
    rms_gradient: float | None = None,
    rms_height: Quantity | None = None,
    seed: int | None = None,
    **others: Any,
) -> Surface:
    """Return a random, periodic surface with C(q) ~ q^(-2(1+H)) between two wavelengths.

    Parameters
    ----------
    length : quantity
        Period L or (Lx, Ly): a number in m, or a text with its unit such as "100 um".
    hurst : float
        H, in [0, 1].
    lambda_long, lambda_short : quantity
        Longest and shortest wavelength.
    rms_gradient, rms_height : float or quantity
        h'_rms or h_rms of C(q), one of the two.
    seed : int
        Names the realisation; the theory alone needs none.
    others
        ``rolloff`` and ``amplitudes``, as in ``[surface]`` of a scene.

    Raises
    ------
    SceneError
        One line for each mistake.

    Examples
    --------
    >>> self_affine(
    ...     length="100 um", hurst=0.8, lambda_long="50 um", lambda_short="5 um", rms_gradient=0.1, seed=3
    ... ).heights(64).shape
    (64, 64)
    """
    table = {"kind": "self-affine", "length": length, "hurst": hurst, "seed": seed, **others}
    table |= {"lambda_long": lambda_long, "lambda_short": lambda_short}
    table |= {"rms_gradient": rms_gradient, "rms_height": rms_height}
    return Surface(table=checked(SelfAffineSurface, "self_affine", table))


def measured(
    heights: Any,
    *,
    length: Quantity | Sequence[Quantity] | None = None,
    unit: Quantity | None = None,
    **treatment: Any,
) -> Surface:
    """Return a measured surface: from a file, an array, or an object of SurfaceTopography.

    Parameters
    ----------
    heights : path, (nx, ny) array, SurfaceTopography topography or HeightField
        A file of any format that scenes read. NaN where there is no height.
    length : quantity
        Size L or (Lx, Ly), number of points times spacing; not needed where `heights` says it.
    unit : quantity
        Unit of the heights, such as "1 nm" or 1e-9; not needed where `heights` says it.
    treatment
        ``tilt``, ``missing``, ``edges``, ``margin`` as in ``[surface]`` of a scene.

    Raises
    ------
    UsageError
        For what gives no surface, or says too little of it.
    """
    if "more_paths" in treatment:
        each = "table([press(measured(path, ...), ...) for path in paths])"
        raise UsageError(f"measured: more_paths is of an ensemble, which a scene has; press each map: {each}")
    table = {"kind": "file", **treatment}
    if not treatment.keys() <= FileSurface.model_fields.keys():
        checked(FileSurface, "measured", table)  # which names the unknown key
    if isinstance(heights, (str, os.PathLike)):
        table |= {"path": str(heights), "length": length, "unit": unit}
        try:
            tables = sized(plain({"surface": table}), Path(), "measured")
        except SceneError as error:  # what else is wrong is told when it is pressed
            others = [words for words in error.problems if not words.startswith("cannot be pressed")]
            raise SceneError("measured", others) from None
        on_file = checked(FileSurface, "measured", tables["surface"])
        return Surface(table=on_file, given=_Measured.read(on_file))
    values, own_length, own_unit, words = _told_by(heights)
    length = own_length if length is None else length
    unit = own_unit if unit is None else unit
    if length is None:
        raise UsageError('measured: length is missing; give the size of the patch, as length="100 um"')
    if unit is None:
        remedy = 'give the unit of the heights, as unit="1 nm" or unit=1 for m'
        raise UsageError(f"measured: unit is missing; {remedy}")
    nx, ny = values.shape
    if np.ndim(length) == 0 and sides_of(length) is None and nx != ny:
        raise UsageError(f"measured: one length for {nx} x {ny} points; give both sides, as length=(Lx, Ly)")
    table |= {"path": words, "length": length, "unit": unit}
    in_memory = checked(FileSurface, "measured", table)
    assert in_memory.unit is not None
    raw = Topography(
        heights=np.where(np.isfinite(values), values, np.nan) * in_memory.unit,
        lengths=in_memory.length,
        history=(f"{words}: {nx} x {ny} points",),
        unit=in_memory.unit,
        digest=hashlib.sha256(repr(values.shape).encode() + values.tobytes()).hexdigest(),
    )
    return Surface(table=in_memory, given=_Measured.of(in_memory, raw))


def _told_by(heights: Any) -> tuple[Any, Pair | None, float | None, str]:
    """Return heights, their size [m], their unit [m] and what they are, as far as the object says it."""
    if isinstance(heights, HeightField):
        return heights.heights, heights.lengths, 1.0, "HeightField"
    what, size, unit = type(heights).__name__, None, None
    try:
        if callable(getattr(heights, "heights", None)) and hasattr(heights, "physical_sizes"):
            unit = metres(heights.unit)
            lx, ly = heights.physical_sizes
            size = None if unit is None else (unit * float(lx), unit * float(ly))
            values = real(np.ma.filled(np.ma.asarray(heights.heights(), dtype=float), np.nan))
        else:
            values = real(np.ma.filled(heights, np.nan))
        check_shape(values.shape)
    except (ValueError, TypeError) as error:
        remedy = "give a file, a 2-D array, or a topography"
        raise UsageError(f"measured: heights of type {what}: {error}; {remedy}") from None
    return values, size, unit, what


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
