"""What passes through a contact and through its gap: stiffness, percolation, leak; the same surface as its waves are added."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Literal

import numpy as np
import xarray as xr

from fem_contact.area import contact_areas
from fem_contact.contact import ContactResult
from fem_contact.leak import critical_gap, flow_conductance, open_gap, percolates
from fem_contact.patches import find_patches
from fem_contact.stress import gap_distribution
from fem_contact.surface import HeightField
from persson.gaps import gap_distribution as theory_of_gaps
from persson.leakage import effective_medium
from persson.scale import Scale
from validation.arrays import Array, Grid
from validation.execution.measurement import measurement
from validation.measurements.limits import shift_means
from validation.measurements.measurement import press_elastic, stacked, without_waves_beyond
from validation.measurements.theory import WITH_ENERGY, Waves
from validation.scenes.problem import ContactProblem

#: Edges over which gaps are counted, as u/h_rms: finer towards zero, where P(u) rises; one of them is 0.1.
GAP_EDGES = 0.1 * (np.arange(39) / 6) ** 2

#: Located area up to which a percolation threshold is bracketed, and how closely an area is met.
_BRACKET, _AREA = 1e-3, 2e-4
#: Steps of a search for a load; each halves its bracket at worst.
_STEPS = 40

#: Loads between which the theory's gap is differentiated, relative.
_STEP = 0.01


def stiffness_of(measured: xr.Dataset, problem: ContactProblem) -> xr.Dataset:
    """Reduce a path with its stiffness to (load) on its finest grid, means over the shifts, and the theory's.

    ``stiffness_each`` K h_rms / p0 with its step from the grid before; by every variant of the theory that
    stores an energy, of the same surface, -h_rms / (d gap / d ln p0).
    """
    fine, before = (measured.isel(grid=k, drop=True) for k in (-1, -2))
    loads, height = measured.reduced_pressure.values, problem.field.rms_height
    waves, gradient = Waves.of_field(problem.field), problem.field.rms_gradient
    around = np.sort(np.concatenate([loads * np.exp(-_STEP), loads * np.exp(_STEP)])) * gradient
    theory = {}
    for variant in WITH_ENERGY:
        gaps = waves.mean_gap(around, variant)
        with np.errstate(divide="ignore"):  # full contact is endlessly stiff
            stiffness = height / ((gaps[0::2] - gaps[1::2]) / (2 * _STEP))
        theory[f"stiffness_{variant}_each"] = ("load", stiffness)
    simulated = shift_means(
        measured,
        stiffness="stiffness.isel(grid=-1)",
        area_perimeter="perimeter.isel(grid=-1)",
        gap="mean_gap.isel(grid=-1) / rms_height",
    )
    with np.errstate(invalid="ignore"):
        simulated["stiffness_each_drift"] = fine.stiffness.mean("shift") - before.stiffness.mean("shift")
    return xr.Dataset({**simulated, **theory})


@measurement(
    "leak-{size}",
    kind="LeakMeasurement",
    words="leak",
    located=True,
    version=3,
    # Some seven problems for each area and threshold.
    seconds=lambda points, areas: 7 * (len(areas) + 4) * (2e-3 + 2e-6 * points),
    bytes=2000,
)
def leaks(*, problem: ContactProblem, grid: Grid, areas: tuple[float, ...]) -> xr.Dataset:
    """Seek the loads that make given areas A/A0, located inside the cells, and where contact and gap percolate.

    What leaks there and how wide the gaps are, over (area, axis) and (area, gap_bin); thresholds (axis).
    """
    press = partial(press_elastic, problem.heights(grid), problem.elastic)

    def threshold_area(percolates: Callable[[ContactResult], bool]) -> float:
        """A/A0 at which a path closes: it is open at a light enough load, and closed at p* = 1."""
        light_load = 0.05
        while not percolates(contact_at(light_load)):
            light_load /= 2
        return contact_at.threshold(percolates, light_load, 1.0, area=_BRACKET)[0]

    contact_at = States(lambda load, start: press(load * problem.pressure_scale, start=start))
    contacts = [contact_at.at_area(area) for area in areas]
    flows = [[_flow(contact, axis) for axis in ("x", "y")] for contact in contacts]
    height = problem.field.rms_height
    data = stacked(flows, "area", "axis") | {
        name: ("axis", [threshold_area(open_at(axis)) for axis in ("x", "y")])
        for name, open_at in (("contact_threshold", contact_is_apart), ("gap_threshold", gap_is_open))
    }
    gaps = [gap_distribution(contact, GAP_EDGES * height).density * height for contact in contacts]
    data["gap_density"] = ("area", "gap_bin"), gaps
    data["reduced_pressure"] = "area", [one.mean_pressure / problem.pressure_scale for one in contacts]
    data["counted"] = "area", [np.mean(one.in_contact) for one in contacts]
    return xr.Dataset(data, coords={"area": list(areas), "axis": ["x", "y"]})


#: Elastic energies of the theory of gaps, by their g (Persson 2006, and Yang, Persson 2008).
GAP_THEORIES = {"persson": 1.0, "yang_persson": 0.45}
#: Gaps, as u/h_rms, that are called narrow.
NARROW = 0.1


def flow_of(measured: xr.Dataset, problem: ContactProblem) -> xr.Dataset:
    """Reduce what `leaks` left to means over both axes, one sample of a surface, beside the theories.

    Over (asked): conductance, Bruggeman's and that of the narrowest place, all over the cube of the mean gap; share
    of axes that are closed; P(u) h_rms and the share of narrow gaps. Over (phase, axis) and (phase): thresholds.
    """
    data = measured.rename(area="asked").rename(asked="area_asked").swap_dims(area_asked="asked")
    phases = [data.contact_threshold, data.gap_threshold]
    along = {
        "area_located": data.located,
        "gap_conductance": data.conductance,
        "gap_conductance_bruggeman": data.effective_medium,
        "gap_conductance_constriction": data.constriction**3 / 12,
        "constriction": data.constriction,
        "closed": data.closed,
        "balance": data.balance,
        "percolation_area": xr.concat(phases, "phase").assign_coords(phase=["contact", "gap"]),
    }
    numbers: dict[str, Any] = {f"{name}_axis_each": value for name, value in along.items()}
    numbers |= {f"{name}_each": value.mean("axis") for name, value in along.items()}
    width = xr.DataArray(np.diff(GAP_EDGES), dims="gap_bin")
    narrow = xr.DataArray(GAP_EDGES[1:] <= NARROW * (1 + 1e-9), dims="gap_bin")
    densities = {
        f"_{name}": data.gap_density.copy(data=_gap_theory(data.reduced_pressure.values, problem, ratio))
        for name, ratio in GAP_THEORIES.items()
    }
    # What counts as contact but lies beyond the located edge is a narrow gap; in the theory nothing does.
    edge = data.counted - data.located.mean("axis")
    for end, density in {"": data.gap_density, **densities}.items():
        share, beyond = density * width, 0.0 if end else edge
        numbers[f"gap_density{end}_each"] = density
        numbers[f"gap_share{end}_each"] = share.cumsum("gap_bin") + beyond
        numbers[f"gap_narrow{end}_each"] = share.where(narrow).sum("gap_bin") + beyond
    numbers["reduced_pressure_each"] = data.reduced_pressure
    return xr.Dataset(numbers).assign_coords(local_gap=("gap_bin", (GAP_EDGES[1:] + GAP_EDGES[:-1]) / 2))


def _gap_theory(loads: Array, problem: ContactProblem, ratio: float) -> Array:
    """P(u) h_rms at the loads of one surface, over (area, gap_bin); three points by Simpson's rule in each bin."""
    height = problem.field.rms_height
    scale = Scale(problem.own_spectrum, contact_modulus=problem.contact_modulus)
    points = np.stack([GAP_EDGES[:-1], (GAP_EDGES[1:] + GAP_EDGES[:-1]) / 2, GAP_EDGES[1:]]) * height
    density = [
        theory_of_gaps(points.ravel(), pressure=load, scale=scale, energy_ratio=ratio)
        for load in loads * problem.pressure_scale
    ]
    return np.array([1, 4, 1]) / 6 @ np.reshape(density, (-1, *points.shape)) * height


class States:
    """Solved contacts by the positive number that tells them apart, each started from the nearest."""

    def __init__(self, solve: Callable[[float, Array | None], ContactResult]) -> None:
        self._solve = solve
        self._contacts: dict[float, ContactResult] = {}

    def __call__(self, at: float) -> ContactResult:
        """Return the contact there, solved once."""
        if at not in self._contacts:
            near = min(self._contacts, key=lambda other: abs(np.log(other / at)), default=None)
            self._contacts[at] = self._solve(at, None if near is None else self._contacts[near].pressure)
        return self._contacts[at]

    def at_area(self, area: float) -> ContactResult:
        """Return the contact whose located area is this one, by secants in a bracket of loads p*."""
        low, high = 0.0, 4.0
        load = area / 2
        for _ in range(_STEPS):
            contact = self(load)
            excess = located_area(contact) / area - 1
            if abs(excess) * area < _AREA:
                break
            low, high = (load, high) if excess < 0 else (low, load)
            guess = load / (1 + excess) ** 1.2
            load = guess if low < guess < high else (low + high) / 2
        return contact

    def threshold(
        self,
        passes: Callable[[ContactResult], bool],
        low: float,
        high: float,
        *,
        area: float,
        ratio: float = 1.0,
    ) -> tuple[float, float]:
        """Return located area and place where it changes whether something passes.

        The bracket is halved in the logarithm until its ends are within an area, or a ratio, of each other.
        """
        before = passes(self(low))
        while abs(located_area(self(high)) - located_area(self(low))) > area and high / low > ratio:
            middle = np.sqrt(low * high)
            low, high = (middle, high) if passes(self(middle)) == before else (low, middle)
        return (located_area(self(low)) + located_area(self(high))) / 2, np.sqrt(low * high)


def located_area(state: ContactResult) -> float:
    """A/A0 with the edge located inside the cells."""
    area = contact_areas(state, subcell=True).subcell
    assert area is not None
    return area


def gap_is_open(axis: Literal["x", "y"]) -> Callable[[ContactResult], bool]:
    """Return the question whether a path without contact leads along an axis."""
    return lambda state: percolates(~state.in_contact, axis)


def contact_is_apart(axis: Literal["x", "y"]) -> Callable[[ContactResult], bool]:
    """Return the question whether no path of contact leads along an axis."""
    return lambda state: not percolates(state.in_contact, axis)


def _flow(state: ContactResult, axis: Literal["x", "y"]) -> dict[str, float]:
    gap = open_gap(state)
    mean = gap.mean()
    flow = flow_conductance(gap, state.lengths, axis=axis)
    medium = effective_medium(gap.ravel() ** 3 / 12, np.full(gap.size, 1 / gap.size))
    return {
        "located": located_area(state),
        "conductance": flow.conductance / mean**3,
        "closed": float(flow.closed),
        "effective_medium": medium / mean**3,
        "constriction": critical_gap(gap, axis) / mean,
        "balance": flow.balance,
    }


#: Located area, and magnification, up to which a threshold is bracketed.
_NEAR, _ZETA = 2e-3, 1.002
_AXES: tuple[Literal["x", "y"], ...] = ("x", "y")


@measurement(
    "magnified-{size}",
    kind="Magnified",
    words="magnified",
    located=True,
    version=2,
    left_out=("load",),
    # One problem for each load and magnification, some twenty for each pair of thresholds.
    seconds=lambda points, reduced_pressures, magnifications, percolating, bends: (
        (len(reduced_pressures) * len(magnifications) + len(bends) + 20 * len(percolating))
        * (2e-3 + 8e-7 * points)
    ),
    bytes=500,
)
def magnified(
    *,
    problem: ContactProblem,
    grid: Grid,
    reduced_pressures: tuple[float, ...],
    magnifications: tuple[float, ...],
    percolating: tuple[float, ...] = (),
    bends: tuple[tuple[float, float], ...] = (),
) -> xr.Dataset:
    """Press one surface at loads p* with the gradient of all waves, with its waves up to each magnification.

    Over (load, magnification); thresholds over (percolating, axis, phase). zeta = q/q_long of the last wave
    there is, rising; `percolating` are the p* at which those are sought where contact and gap join up;
    `bends` pairs of p* and zeta that are looked at alone, over (load) where they have one of the loads.
    """
    heights, field, zetas = problem.heights(grid), problem.field, dict(bends)

    def cut(surface: HeightField, zeta: float) -> HeightField:
        return without_waves_beyond(surface, zeta * 2 * np.pi / problem.longest)

    def states_at(load: float) -> States:
        """Contacts by magnification."""
        press = partial(press_elastic, solid=problem.elastic, pressure=load * problem.pressure_scale)
        return States(lambda zeta, start: press(cut(heights, zeta), start=start))

    def threshold(states: States, passes: Callable[[ContactResult], bool]) -> tuple[float, float]:
        low, high = magnifications[0], magnifications[-1]
        if passes(states(low)) or not passes(states(high)):
            return np.nan, np.nan
        return states.threshold(passes, low, high, area=_NEAR, ratio=_ZETA)

    rows = []
    for load in reduced_pressures:
        states, unit = states_at(load), problem.longest**2
        last = states(magnifications[-1])
        rows.append([_read_off(states(zeta), last, unit=unit) for zeta in reversed(magnifications)][::-1])
    data = {f"{name}_each": values for name, values in stacked(rows, "load", "magnification").items()}
    thresholds = [
        [[threshold(states, phase(axis)) for phase in (contact_is_apart, gap_is_open)] for axis in _AXES]
        for states in map(states_at, percolating)
    ]
    for k, name in enumerate(("area", "magnification")):
        values = np.reshape(thresholds, (-1, 2, 2, 2))[..., k]
        data[f"percolation_{name}_axis_each"] = ("percolating", "axis", "phase"), values
    shares = {
        zeta: cut(field, zeta).rms_gradient / field.rms_gradient
        for zeta in (*magnifications, *zetas.values())
    }
    data["gradient_share_each"] = "magnification", [shares[zeta] for zeta in magnifications]
    macro = {load: located_area(states_at(load)(zetas[load])) for load in reduced_pressures if load in zetas}
    data["macro_area_each"] = "load", [macro.get(load, np.nan) for load in reduced_pressures]
    data["macro_gradient_share_each"] = (
        "load",
        [shares[zetas[load]] if load in zetas else np.nan for load in reduced_pressures],
    )
    return xr.Dataset(data, coords={"axis": list(_AXES), "phase": ["contact", "gap"]})


def _read_off(state: ContactResult, last: ContactResult, *, unit: float) -> dict[str, float]:
    """Numbers of a contact, and its shares of the contact at the largest magnification, `last`; `unit` is an area [m^2]."""
    patches = find_patches(state.in_contact, state.spacing)
    nominal = state.lengths[0] * state.lengths[1]
    inside = last.in_contact & state.in_contact
    return {
        "area": located_area(state),
        "patch_density": patches.count * unit / nominal,
        "relative_patch_size": patches.mean_size / unit,
        "largest_patch": patches.areas.max() / patches.areas.sum(),
        "area_inside": inside.sum() / last.in_contact.sum(),
        "load_inside": last.pressure[inside].sum() / last.pressure.sum(),
    }
