"""How much of the contact has yielded, by boundary elements over grids and by Persson's theory?

Surfaces of several seeds against a solid of given hardness, on a ladder of grids: elastic and plastic area in
the limit over the grids against load, and against magnification as the same surfaces gain wave after wave,
beside the closed form for constant hardness with the gradient of the same surfaces; and the spectrum of the
smoothed surface left behind, beside Persson's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from fem_contact.hardness import yielded
from fem_contact.surface import HeightField, radial_spectrum
from persson import elastic
from persson.hardness import constant_hardness
from persson.scale import Scale
from persson.tabulated import smoothed
from validation.arrays import Array
from validation.effects.hardness import Hardness
from validation.measures.common import named, truncated_surface
from validation.scenes.realised import Realised
from validation.scenes.scene import Load, SelfAffineSurface, SolidSpec
from validation.solves.bench import Bench
from validation.solves.press import Press
from validation.studies._options import Bandwidth, Hurst, Periods, Seed
from validation.studies._study import StudyOptions
from validation.units import Positive, wrong

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.drawing import Drawing
    from validation.solves.running import Solves

__all__ = ["Options", "figures", "findings", "run"]

_Positives = Annotated[tuple[Positive, ...], Field(min_length=1)]

_SOLID = SolidSpec(young=1e9, poisson=0.3)
_MODULUS = _SOLID.young / (1 - _SOLID.poisson**2)
_GRADIENT, _LENGTH = 0.1, 1e-4
_PARTS = ("plastic", "elastic")


class Options(StudyOptions):
    """What is pressed, how hard it is, and how often."""

    own = "it turns load and waves by itself; `area` takes a scene that yields"

    reduced_pressures: _Positives = Field(
        default=(0.01, 0.02, 0.05, 0.1, 0.2),
        description="p* = p0 / (E* h'_rms) with the realised gradient of all waves",
    )
    magnifications: _Positives = Field(
        default=(1.25, 1.5, 2.0, 3.0, 4.0),
        description="zeta = q/q_long of the last wave there is, above 1, at most the bandwidth",
    )
    hardness: Positive = Field(default=0.6, description="H / (E* h'_rms) with the gradient asked for")
    smoothing_reduced_pressure: Positive = Field(
        default=0.1, description="p* at which magnifications are walked through and surfaces are smoothed"
    )
    seed: Seed = 11
    surfaces: int = Field(default=2, ge=1, le=10_000, description="how many")
    grids: Annotated[tuple[Annotated[int, Field(ge=2)], ...], Field(min_length=1)] = Field(
        default=(64, 128, 256),
        description="points along a side; the limit is that of the two finest, the one before says how sure it is",
    )
    hurst: Hurst = 0.8
    periods: Periods = 4.0
    bandwidth: Bandwidth = 4.0

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if len(set(self.grids)) < 2:
            raise wrong(f"grids = {', '.join(map(str, self.grids))}: at least two, for a limit")
        if not all(1 < zeta <= self.bandwidth for zeta in self.magnifications):
            values = ", ".join(f"{zeta:g}" for zeta in self.magnifications)
            raise wrong(
                f"magnifications = {values}: must lie above 1, at most bandwidth = {self.bandwidth:g}"
            )
        return self

    @property
    def ladder(self) -> tuple[int, ...]:
        """Grids, rising, each once."""
        return tuple(sorted(set(self.grids)))

    def surface(self, k: int, *, until: float) -> SelfAffineSurface:
        """Return one surface with its waves up to a magnification."""
        whole = {"length": _LENGTH, "gradient": _GRADIENT, "bandwidth": self.bandwidth}
        return truncated_surface(until, seed=self.seed + k, hurst=self.hurst, periods=self.periods, **whole)


@dataclass(frozen=True, kw_only=True)
class _Case:
    """One surface with its waves up to some magnification, at one nominal pressure, on a solid of a hardness [Pa]."""

    realised: Realised
    hardness: float

    def solve(self, n: int) -> Press:
        return Press(
            method="bem",
            grid=(n, n),
            realised=self.realised,
            settings=(("tolerance", 1e-8),),
            effects=(Hardness(hardness=self.hardness),),
        )

    def theory(self) -> Array:
        """A_pl/A0 and A_el/A0 with the gradient of this very surface."""
        realised = self.realised
        variance = elastic.stress_variance(
            realised.field.moments[1], contact_modulus=realised.contact_modulus
        )
        parts = constant_hardness(realised.pressure, stress_variance=variance, yield_stress=self.hardness)
        return np.array([float(parts.plastic), float(parts.elastic)])


#: Cases by load or magnification, one for each surface.
_Rows = Sequence[Sequence[_Case]]


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Solve every surface at every load and magnification on every grid.

    Returns
    -------
    xarray.Dataset
        Over `reduced_pressure` and over `magnification`: A_pl/A0 and A_el/A0 in the limit of the two finest grids,
        linear in dx, averaged over the surfaces, with the uncertainty from grids and surfaces; the finest grid; the
        theory. Over `wave`: share of C(q) that the smoothed surfaces keep, and Persson's.
    """
    by_load, by_wave, last = _cases(options)
    every = [case for row in [*by_load, *by_wave, last] for case in row]
    solved = bench.solve([case.solve(n) for case in every for n in options.ladder])
    columns = _columns(by_load, options.ladder, solved, dimension="reduced_pressure")
    columns |= _columns(by_wave, options.ladder, solved, dimension="magnification", suffix="_grown")
    return _dataset(options, columns, kept=_kept(last, options.ladder[-1], solved))


def _cases(options: Options) -> tuple[_Rows, _Rows, Sequence[_Case]]:
    """List the cases by load, by magnification, and those that are smoothed, each surface after the other."""
    hardness = options.hardness * _MODULUS * _GRADIENT
    surfaces = range(options.surfaces)

    def realised(k: int, until: float, pressure: float) -> Realised:
        return Realised(surface=options.surface(k, until=until), solid=_SOLID, load=Load(pressure=pressure))

    units = [realised(k, options.bandwidth, 1.0).pressure_scale for k in surfaces]

    def row(load: float, until: float) -> list[_Case]:
        return [_Case(realised=realised(k, until, load * units[k]), hardness=hardness) for k in surfaces]

    smoothing = options.smoothing_reduced_pressure
    by_load = [row(load, options.bandwidth) for load in options.reduced_pressures]
    by_wave = [row(smoothing, zeta) for zeta in options.magnifications]
    return by_load, by_wave, row(smoothing, options.bandwidth)


def _dataset(options: Options, columns: dict[str, Any], *, kept: _Kept) -> xr.Dataset:
    """Put areas and spectra together."""
    import xarray as xr

    ratio = {"units": "1", "long_name": "C(q) left by smoothing, over C(q)"}
    columns["kept"] = ("wave", kept.measured, ratio)
    columns["kept_persson"] = named("wave", kept.theory, "1 - A_pl(q)/A_pl, Persson", unit="1")
    names = {"reduced_pressure": "p* = p0 / (E* h'_rms)", "magnification": "q / q_long of the last wave"}
    along = {"reduced_pressure": options.reduced_pressures, "magnification": options.magnifications}
    coords = {name: named(name, np.asarray(values), names[name], unit="1") for name, values in along.items()}
    coords["wave"] = named("wave", kept.q, "q / q_long", unit="1")
    said = {
        "surfaces": options.surfaces,
        "hardness": options.hardness,
        "smoothing_reduced_pressure": options.smoothing_reduced_pressure,
        "gradient_kept_inside": kept.inside,
    }
    return xr.Dataset(columns, coords=coords, attrs={"methods": "theory bem", **said})


def _columns(
    rows: _Rows,
    ladder: tuple[int, ...],
    solved: Solves,
    *,
    dimension: str,
    suffix: str = "",
) -> dict[str, tuple[str, Array, dict[str, str]]]:
    """Limits, their uncertainty, finest grid and theory of both parts of the area."""
    # row, surface, grid, part
    found = np.array([[[_parts(solved[case.solve(n)]) for n in ladder] for case in row] for row in rows])
    theory = np.array([[case.theory() for case in row] for row in rows])
    limits = _linear(found[:, :, -2], found[:, :, -1], ladder[-2] / ladder[-1])
    coarser = (
        _linear(found[:, :, -3], found[:, :, -2], ladder[-3] / ladder[-2])
        if len(ladder) > 2
        else found[:, :, -1]
    )
    grid = np.abs(limits - coarser).mean(axis=1)
    count = limits.shape[1]
    scatter = limits.std(axis=1, ddof=1) / count**0.5 if count > 1 else np.zeros_like(grid)
    columns = {}
    for k, part in enumerate(_PARTS):
        for name, values, words in (
            ("", limits.mean(axis=1), "limit over grids"),
            ("_finest", found[:, :, -1].mean(axis=1), "finest grid"),
            ("_persson", theory.mean(axis=1), "Persson"),
        ):
            text = {"units": "1", "long_name": f"A_{part[:2]}/A0, {words}"}
            columns[f"{part}{suffix}{name}"] = (dimension, values[:, k], text)
        error = {"units": "1", "long_name": f"standard error of A_{part[:2]}/A0, grids and surfaces"}
        columns[f"{part}{suffix}_error"] = (dimension, np.hypot(grid, scatter)[:, k], error)
    return columns


def _parts(contact: Any) -> tuple[float, float]:
    found = yielded(contact.checked())
    return found.plastic_area, found.elastic_area


def _linear(coarse: Array, fine: Array, ratio: float) -> Array:
    """Return the limit of something linear in dx; `ratio` is that of the spacings, fine over coarse."""
    return np.asarray((fine - ratio * coarse) / (1 - ratio))


@dataclass(frozen=True, kw_only=True)
class _Kept:
    """What smoothing leaves, means over the surfaces.

    Attributes
    ----------
    q : (n,) array
        Over q_long.
    measured, theory : (n,) arrays
        Share of C(q) that is left.
    inside : float
        Share of <|grad h|^2> that is left where the surface yielded.
    """

    q: Array
    measured: Array
    theory: Array
    inside: float


def _kept(cases: Sequence[_Case], n: int, solved: Solves) -> _Kept:
    """Read off the surfaces left behind what smoothing leaves, beside Persson's."""
    q, measured, theory, inside = zip(*(_kept_of(case, n, solved) for case in cases), strict=True)
    return _Kept(
        q=q[-1],
        measured=np.mean(measured, axis=0),
        theory=np.mean(theory, axis=0),
        inside=float(np.mean(inside)),
    )


def _kept_of(case: _Case, n: int, solved: Solves) -> tuple[Array, Array, Array, float]:
    """Waves over q_long, the share left at each, Persson's, and the share of the squared gradient."""
    contact = solved[case.solve(n)].checked()
    before = HeightField(heights=np.array(contact.heights), lengths=contact.lengths)
    after = yielded(contact).surface
    spectrum = case.realised.spectrum_shape
    rings, left = radial_spectrum(before), radial_spectrum(after)
    own = (rings.q >= spectrum.q_long) & (rings.q <= spectrum.q_short)
    slopes = [_squared_gradient(field)[contact.at_bound].mean() for field in (before, after)]
    measured, theory = left.power[own] / rings.power[own], _kept_by_theory(case, rings.q[own])
    return rings.q[own] / spectrum.q_long, measured, theory, slopes[1] / slopes[0]


def _kept_by_theory(case: _Case, q: Array) -> Array:
    """Share of C(q) that Persson's formula leaves at wavevectors (2006, Sec. 10.2)."""
    realised, spectrum = case.realised, case.realised.spectrum_shape
    scaled = spectrum.scaled(float(realised.field.rms_gradient**2 / spectrum.m2()))
    fine = np.geomspace(spectrum.q_long, spectrum.q_short, 400)
    variance = Scale(scaled, contact_modulus=realised.contact_modulus).variance(fine)
    parts = constant_hardness(realised.pressure, stress_variance=variance, yield_stress=case.hardness)
    share = np.minimum(parts.plastic * case.hardness / realised.pressure, 1.0)
    return np.asarray(smoothed(scaled, wavevectors=fine, yielded=share)(q) / scaled(q))


def _squared_gradient(field: HeightField) -> Array:
    dx, dy = field.spacing
    h = field.heights
    gx = (np.roll(h, -1, axis=0) - np.roll(h, 1, axis=0)) / (2 * dx)
    gy = (np.roll(h, -1, axis=1) - np.roll(h, 1, axis=1)) / (2 * dy)
    return np.asarray(gx**2 + gy**2)


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Say how far the theory is from the limit, and how much of the spectrum is left."""
    sentences = []
    for dimension, suffix, words in (
        ("reduced_pressure", "", "p*"),
        ("magnification", "_grown", "magnification"),
    ):
        for k in sorted({0, data.sizes[dimension] - 1}):
            point = data.isel({dimension: k})
            parts = [_beside(point, part, suffix) for part in _PARTS]
            at = f"{words} = {float(point[dimension]):.3g}"
            if suffix:
                at += f" (p* = {data.attrs['smoothing_reduced_pressure']:.3g} with all waves)"
            sentences.append(f"At {at} and H = {data.attrs['hardness']:.3g} E* h'_rms: {'; '.join(parts)}.")
    sentences.append(_smoothing(data))
    return tuple(sentences)


def _beside(point: xr.Dataset, part: str, suffix: str) -> str:
    from validation.comparison.findings import percent

    found, error = float(point[part + suffix]), float(point[f"{part}{suffix}_error"])
    theory = float(point[f"{part}{suffix}_persson"])
    where = "above" if theory > found else "below"
    away = "" if found <= 0 else f", {percent(abs(theory / found - 1))} {where} it"
    return f"A_{part[:2]}/A0 = {found:.4f} +- {error:.4f} in the limit and {theory:.4f} by Persson{away}"


def _smoothing(data: xr.Dataset) -> str:
    kept, theory = (float(data[name].values[-1]) for name in ("kept", "kept_persson"))
    worst = float(np.max(np.abs(data["kept"].values - data["kept_persson"].values)))
    return (
        f"Smoothed at p* = {data.attrs['smoothing_reduced_pressure']:.3g}, the surface keeps {kept:.3g} of C(q) at "
        f"q = {float(data['wave'].values[-1]):.3g} q_long, where Persson's formula leaves {theory:.3g} "
        f"(largest difference {worst:.2g}): it smooths the whole surface, boundary elements only what has "
        f"yielded, where {data.attrs['gradient_kept_inside']:.2g} of the squared gradient is left."
    )


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw plastic and elastic area against load and magnification, and the spectrum that is left."""
    from validation.report.drawing import Drawing
    from validation.report.figure import lines_figure

    drawings = []
    for x, suffix, words in (("reduced_pressure", "", "load"), ("magnification", "_grown", "magnification")):
        for part in _PARTS:
            lines = (f"{part}{suffix}", f"{part}{suffix}_finest", f"{part}{suffix}_persson")
            drawings.append(
                Drawing(
                    name=f"{part}-area" + ("-magnification" if suffix else ""),
                    figure=lines_figure(data, x=x, lines=lines, logarithmic="x"),
                    data=data[[*lines, f"{part}{suffix}_error"]],
                    caption=f"Share of the nominal area in {part} contact against {words}: limit over the "
                    "grids with its uncertainty from grids and surfaces, finest grid, and Persson's theory "
                    "with the gradient of the same surfaces.",
                )
            )
    drawings.append(
        Drawing(
            name="smoothed-spectrum",
            figure=lines_figure(data, x="wave", lines=("kept", "kept_persson"), logarithmic="x"),
            data=data[["kept", "kept_persson"]],
            caption="Spectrum of the surface left after yielding and unloading, over that before: measured, "
            "and Persson's formula, which smooths the whole surface (2006, Sec. 10.2).",
        )
    )
    return tuple(drawings)
