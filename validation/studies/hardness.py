"""How much of the contact has yielded, by boundary elements over grids and by Persson's theory?

Surfaces of several seeds against a solid of given hardness, on a ladder of grids: elastic and plastic area in
the limit over the grids against load, and against magnification as the same surfaces gain wave after wave,
beside the closed form for constant hardness with the gradient of the same surfaces; and the spectrum of the
smoothed surface left behind, beside Persson's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fem_contact.hardness import yielded
from fem_contact.surface import HeightField, radial_spectrum
from persson import elastic
from persson.hardness import constant_hardness
from persson.scale import Scale
from persson.tabulated import smoothed
from validation.effects.hardness import Hardness
from validation.errors import UsageError
from validation.measures.common import truncated_surface
from validation.scenes.realised import Realised
from validation.scenes.scene import Load, SelfAffineSurface, SolidSpec
from validation.scenes.surfaces import reference_field, spectrum_of
from validation.solves.bench import Bench
from validation.solves.press import Press

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.drawing import Drawing
    from validation.solves.running import Solves

__all__ = ["figures", "findings", "run"]

Array = NDArray[np.float64]

_SOLID = SolidSpec(young=1e9, poisson=0.3)
_MODULUS = _SOLID.young / (1 - _SOLID.poisson**2)
_GRADIENT, _LENGTH = 0.1, 1e-4
_PARTS = ("plastic", "elastic")


@dataclass(frozen=True, kw_only=True)
class _Case:
    """One surface with its waves up to some magnification, at one nominal pressure [Pa]."""

    surface: SelfAffineSurface
    pressure: float
    hardness: float

    def solve(self, n: int) -> Press:
        return Press(
            method="bem",
            grid=(n, n),
            realised=Realised(surface=self.surface, solid=_SOLID, load=Load(pressure=self.pressure)),
            settings=(("tolerance", 1e-8),),
            effects=(Hardness(kind="hardness", hardness=self.hardness),),
        )

    def theory(self) -> Array:
        """A_pl/A0 and A_el/A0 with the gradient of this very surface."""
        variance = elastic.stress_variance(reference_field(self.surface).moments[1], contact_modulus=_MODULUS)
        parts = constant_hardness(self.pressure, stress_variance=variance, yield_stress=self.hardness)
        return np.array([float(parts.plastic), float(parts.elastic)])


def run(
    *,
    bench: Bench | None = None,
    pressures: tuple[float, ...] = (0.01, 0.02, 0.05, 0.1, 0.2),
    magnifications: tuple[float, ...] = (1.25, 1.5, 2.0, 3.0, 4.0),
    hardness: float = 0.6,
    smoothing_pressure: float = 0.1,
    seeds: tuple[int, ...] = (11, 12),
    grids: tuple[int, ...] = (64, 128, 256),
    hurst: float = 0.8,
    periods: float = 4.0,
    bandwidth: float = 4.0,
) -> xr.Dataset:
    """Solve every seed at every load and magnification on every grid.

    Parameters
    ----------
    bench : Bench, optional
        Where the solves run and are stored; results/solves if not given.
    pressures : tuple of float
        p* = p0 / (E* h'_rms) with the realised gradient of all waves.
    magnifications : tuple of float
        zeta = q/q_long of the last wave there is, above 1 and at most the bandwidth.
    hardness : float
        H / (E* h'_rms) with the gradient asked for.
    smoothing_pressure : float
        p* at which magnifications are walked through and surfaces are smoothed.
    seeds, grids : tuple of int
        Realisations, and points along a side; at least two grids.
    hurst, periods, bandwidth : float
        H, L / lambda_long, lambda_long / lambda_short.

    Returns
    -------
    xarray.Dataset
        Over `pressure` and over `magnification`: A_pl/A0 and A_el/A0 in the limit of the two finest grids,
        linear in dx, averaged over the seeds, with the uncertainty from grids and seeds; the finest grid; the
        theory. Over `wave`: share of C(q) that the smoothed surfaces keep, and Persson's.

    Raises
    ------
    UsageError
        For fewer than two grids, or magnifications outside the bandwidth.
    """
    import xarray as xr

    if len(set(grids)) < 2:
        raise UsageError(f"--grids = {grids}: at least two, for a limit")
    if not all(1 < zeta <= bandwidth for zeta in magnifications):
        raise UsageError(f"--magnifications = {magnifications}: must lie above 1, at most {bandwidth:g}")
    bench = bench or Bench.at()
    limit = hardness * _MODULUS * _GRADIENT

    def cut(until: float) -> list[SelfAffineSurface]:
        shape = {"hurst": hurst, "periods": periods, "bandwidth": bandwidth}
        return [truncated_surface(seed, until, length=_LENGTH, gradient=_GRADIENT, **shape) for seed in seeds]

    whole = cut(bandwidth)
    units = [_MODULUS * reference_field(surface).rms_gradient for surface in whole]

    def cases(load: float, surfaces: Sequence[SelfAffineSurface]) -> list[_Case]:
        return [
            _Case(surface=surface, pressure=load * unit, hardness=limit)
            for surface, unit in zip(surfaces, units, strict=True)
        ]

    by_load = [cases(load, whole) for load in pressures]
    by_wave = [cases(smoothing_pressure, cut(zeta)) for zeta in magnifications]
    last = cases(smoothing_pressure, whole)
    ladder = tuple(sorted(set(grids)))
    solved = bench.solve(
        [case.solve(n) for row in [*by_load, *by_wave, last] for case in row for n in ladder]
    )
    columns = _columns(by_load, ladder, solved, dimension="pressure")
    columns |= _columns(by_wave, ladder, solved, dimension="magnification", suffix="_grown")
    q, kept, theory, inside = _kept(last, ladder[-1], solved)
    ratio = {"units": "1", "long_name": "C(q) left by smoothing, over C(q)"}
    columns["kept"] = ("wave", kept, ratio)
    columns["kept_persson"] = ("wave", theory, {"units": "1", "long_name": "1 - A_pl(q)/A_pl, Persson"})
    names = {"pressure": "p* = p0 / (E* h'_rms)", "magnification": "q / q_long of the last wave"}
    coords = {
        name: (name, np.asarray(values), {"units": "1", "long_name": names[name]})
        for name, values in (("pressure", pressures), ("magnification", magnifications))
    }
    coords["wave"] = ("wave", q, {"units": "1", "long_name": "q / q_long"})
    return xr.Dataset(
        columns,
        coords=coords,
        attrs={
            "methods": "theory bem",
            "surfaces": len(seeds),
            "hardness": hardness,
            "smoothing_pressure": smoothing_pressure,
            "gradient_kept_inside": inside,
        },
    )


def _columns(
    rows: Sequence[Sequence[_Case]],
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


def _kept(cases: Sequence[_Case], n: int, solved: Solves) -> tuple[Array, Array, Array, float]:
    """Share of C(q) that smoothing leaves, Persson's, and the share of <|grad h|^2> left where it yielded."""
    measured, theory, inside = [], [], []
    for case in cases:
        contact = solved[case.solve(n)].checked()
        before = HeightField(heights=np.array(contact.heights), lengths=contact.lengths)
        after = yielded(contact).surface
        spectrum = spectrum_of(case.surface)
        rings, left = radial_spectrum(before), radial_spectrum(after)
        own = (rings.q >= spectrum.q_long) & (rings.q <= spectrum.q_short)
        measured.append(left.power[own] / rings.power[own])
        q = rings.q[own] / spectrum.q_long
        scaled = spectrum.scaled(float(reference_field(case.surface).rms_gradient ** 2 / spectrum.m2()))
        fine = np.geomspace(spectrum.q_long, spectrum.q_short, 400)
        variance = Scale(scaled, contact_modulus=_MODULUS).variance(fine)
        parts = constant_hardness(case.pressure, stress_variance=variance, yield_stress=case.hardness)
        share = np.minimum(parts.plastic * case.hardness / case.pressure, 1.0)
        bar = smoothed(scaled, wavevectors=fine, yielded=share)
        theory.append(bar(rings.q[own]) / scaled(rings.q[own]))
        slopes = [_squared_gradient(field)[contact.at_bound].mean() for field in (before, after)]
        inside.append(slopes[1] / slopes[0])
    return q, np.mean(measured, axis=0), np.mean(theory, axis=0), float(np.mean(inside))


def _squared_gradient(field: HeightField) -> Array:
    dx, dy = field.spacing
    h = field.heights
    gx = (np.roll(h, -1, axis=0) - np.roll(h, 1, axis=0)) / (2 * dx)
    gy = (np.roll(h, -1, axis=1) - np.roll(h, 1, axis=1)) / (2 * dy)
    return np.asarray(gx**2 + gy**2)


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Say how far the theory is from the limit, and how much of the spectrum is left."""
    sentences = []
    for dimension, suffix, words in (("pressure", "", "p*"), ("magnification", "_grown", "magnification")):
        for k in sorted({0, data.sizes[dimension] - 1}):
            point = data.isel({dimension: k})
            parts = [_beside(point, part, suffix) for part in _PARTS]
            at = f"{words} = {float(point[dimension]):.3g}"
            if suffix:
                at += f" (p* = {data.attrs['smoothing_pressure']:.3g} with all waves)"
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
        f"Smoothed at p* = {data.attrs['smoothing_pressure']:.3g}, the surface keeps {kept:.3g} of C(q) at "
        f"q = {float(data['wave'].values[-1]):.3g} q_long, where Persson's formula leaves {theory:.3g} "
        f"(largest difference {worst:.2g}): it smooths the whole surface, boundary elements only what has "
        f"yielded, where {data.attrs['gradient_kept_inside']:.2g} of the squared gradient is left."
    )


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw plastic and elastic area against load and magnification, and the spectrum that is left."""
    from validation.report.drawing import Drawing
    from validation.report.figure import lines_figure

    drawings = []
    for x, suffix, words in (("pressure", "", "load"), ("magnification", "_grown", "magnification")):
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
