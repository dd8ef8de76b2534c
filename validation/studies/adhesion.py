"""How much does adhesion enlarge the contact, by boundary elements and by Persson's theory?

One surface at one load against works of adhesion that rise from nothing; the range of the attraction is as
short as the grid resolves, because the theory knows none.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from fem_contact.adhesion import CELLS_NEEDED
from persson import elastic
from persson.adhesion import Interface, solve_adhesion
from persson.errors import PerssonError
from persson.scale import Scale
from validation.bench import Bench
from validation.effect_tables import Adhesion
from validation.jobs import Job
from validation.neglect import full_contact_energy
from validation.scene import Load, SelfAffineSurface, SolidSpec
from validation.surfaces import reference_field, spectrum_of

if TYPE_CHECKING:
    import xarray as xr

    from validation.drawing import Drawing

__all__ = ["figures", "findings", "run"]

_SOLID = SolidSpec(young=1e7, poisson=0.5)


def run(
    *,
    bench: Bench | None = None,
    works: tuple[float, ...] = (0.003, 0.01, 0.03, 0.1, 0.2),
    pressure: float = 0.05,
    seed: int = 11,
    grid: int = 256,
    hurst: float = 0.8,
    periods: float = 2.0,
    bandwidth: float = 8.0,
) -> xr.Dataset:
    """Solve one surface for every work of adhesion, and once without.

    Parameters
    ----------
    bench : Bench, optional
        Where the solves run and are stored; results/solves if not given.
    works : tuple of float
        Works of adhesion over the elastic energy per area of full contact, w / U_full, rising.
    pressure : float
        p* = p0 / (E* h'_rms).
    seed, grid : int
        Realisation, points along a side.
    hurst, periods, bandwidth : float
        H, L / lambda_long, lambda_long / lambda_short.

    Returns
    -------
    xarray.Dataset
        Over `work`: A/A0 with adhesion, without, and by the theory with both readings of its elastic energy,
        scaled to the realised gradient; gamma_eff/w of the macroscopic interface; the range over h_rms.
    """
    import xarray as xr

    bench = bench or Bench.at()
    length = 1e-5
    surface = SelfAffineSurface(
        kind="self-affine",
        length=(length, length),
        hurst=hurst,
        lambda_long=length / periods,
        lambda_short=length / periods / bandwidth,
        rms_gradient=0.1,
        seed=seed,
    )
    field = reference_field(surface)
    modulus = _SOLID.young / (1 - _SOLID.poisson**2)
    energy = full_contact_energy(field, modulus=modulus)
    load = Load(reduced_pressure=pressure)

    def job(*effects: Adhesion) -> Job:
        return Job(
            method="bem",
            grid=(grid, grid),
            surface=surface,
            solid=_SOLID,
            load=load,
            settings=(("tolerance", 1e-8),),
            effects=effects,
        )

    plain, sticky = job(), []
    for share in works:
        work = share * energy
        # The shortest range whose process zone spans the cells that are needed, and a little more.
        reach = math.sqrt(1.1 * CELLS_NEEDED * length / grid * work / modulus)
        sticky.append(job(Adhesion(kind="adhesion", work=work, reach=reach)))
    solved = bench.solve([plain, *sticky])
    spectrum = spectrum_of(surface)
    scaled = spectrum.scaled(float(field.rms_gradient**2 / spectrum.m2()))
    scale = Scale(scaled, contact_modulus=modulus)
    nominal = pressure * modulus * field.rms_gradient
    theory = {"improved": np.full(len(works), np.nan), "old": np.full(len(works), np.nan)}
    macroscopic = np.full(len(works), np.nan)
    for k, share in enumerate(works):
        for reading in ("improved", "old"):
            try:
                found = solve_adhesion(
                    scale,
                    pressure=nominal,
                    interface=Interface(work_of_adhesion=share * energy, energy=reading),
                ).checked()
            except PerssonError:
                continue
            theory[reading][k] = found.real_area
            if reading == "improved":
                macroscopic[k] = found.macroscopic_work / (share * energy)
    without = elastic.contact_area(
        nominal, stress_variance=elastic.stress_variance(field.moments[1], contact_modulus=modulus)
    )
    count = len(works)
    areas = [float(np.mean(solved[one].checked().in_contact)) for one in sticky]
    plain_area = float(np.mean(solved[plain].checked().in_contact))
    reaches = [one.effects[0].reach / field.rms_height for one in sticky]  # type: ignore[union-attr]
    columns = {
        "area": (np.array(areas), "A/A0 with adhesion, pixels"),
        "plain": (np.full(count, plain_area), "A/A0 without adhesion, pixels"),
        "improved": (theory["improved"], "A/A0, Persson, energy of Eqs. 44-49"),
        "old": (theory["old"], "A/A0, Persson, energy of Eq. 43"),
        "persson_plain": (np.full(count, float(without)), "A/A0, Persson without adhesion"),
        "macroscopic": (macroscopic, "gamma_eff / w of the whole interface, Persson"),
        "reach": (np.array(reaches), "range of the attraction over h_rms"),
    }
    return xr.Dataset(
        {
            name: ("work", values, {"units": "1", "long_name": words})
            for name, (values, words) in columns.items()
        },
        coords={"work": ("work", np.asarray(works), {"units": "1", "long_name": "w / U_full"})},
        attrs={"methods": "theory bem", "pressure": pressure},
    )


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Say by how much adhesion enlarges the contact at every work, in both."""
    sentences = []
    for k in range(data.sizes["work"]):
        point = data.isel(work=k)
        gain = float(point["area"] / point["plain"])
        text = (
            f"w = {float(point['work']):.3g} U_full, range {float(point['reach']):.2g} h_rms: adhesion "
            f"multiplies the area by {gain:.3g} by boundary elements"
        )
        for reading in ("improved", "old"):
            if math.isfinite(float(point[reading])):
                factor = float(point[reading] / point["persson_plain"])
                text += f", by {factor:.3g} in the theory ({reading})"
            else:
                text += f"; the theory ({reading}) gives no answer"
        sentences.append(text + ".")
    return tuple(sentences)


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw the area against the work of adhesion."""
    from validation import plots
    from validation.drawing import Drawing

    lines = ("area", "plain", "improved", "old", "persson_plain")
    return (
        Drawing(
            name="adhesive-area",
            figure=plots.lines_figure(data, x="work", lines=lines, logarithmic="x"),
            data=data[[*lines, "macroscopic", "reach"]],
            caption="Contact area against the work of adhesion: boundary elements with the shortest range "
            "that the grid resolves, and Persson's theory with two readings of the elastic energy.",
        ),
    )
