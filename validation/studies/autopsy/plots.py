"""Figures of the autopsy."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.report.figure import COLOURS, THEORY, look, new_figure
from validation.studies.autopsy import reading
from validation.studies.autopsy.reading import Spread

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "area_and_restarts",
    "budget_bars",
    "drift_and_diffusivity",
    "fluxes",
    "memory",
]

_LINES = ("-", "--", "-.", ":")
_PROFILE_STEP = 0.01


def nearest(values: xr.DataArray, wanted: float) -> int:
    """Index of the value nearest to a number, by ratio."""
    return int(np.argmin(np.abs(np.log(values.values / wanted))))


def drift_and_diffusivity(dataset: xr.Dataset, *, load: int) -> Figure:
    """D by step, D by magnification, and the drift by magnification, over p/sqrt V at one load."""
    figure, (by_step, by_zeta, drift) = new_figure(width=11.0, height=3.8, columns=3)
    hurst, probe = dataset.sizes["hurst"] - 1, dataset.sizes["probe"] - 1
    at = dataset.isel(hurst=hurst, load=load)
    for k, step in enumerate(dataset.relative_step.values):
        p, _, d = reading.profiles(at, probe=probe, step=k)
        by_step.plot(p, d, label=rf"$\Delta V/V$ = {step:g}", ls=_LINES[k % 4], color=COLOURS[k], lw=1.2)
    chosen = nearest(dataset.relative_step, _PROFILE_STEP)
    for h, exponent in enumerate(dataset.hurst.values):
        at = dataset.isel(hurst=h, load=load)
        for z, zeta in enumerate(dataset.probe_zeta.values):
            p, mu, d = reading.profiles(at, probe=z, step=chosen)
            style: dict[str, Any] = {"color": COLOURS[z], "ls": _LINES[h % 4], "lw": 1.2}
            label = rf"$\zeta$ = {zeta:g}, H = {exponent:g}"
            by_zeta.plot(p, d, label=label, **style)
            drift.plot(p, mu, label=label, **style)
    step = float(dataset.relative_step[chosen])
    by_step.set_title(
        rf"H = {float(dataset.hurst[hurst]):g}, $\zeta$ = {float(dataset.probe_zeta[probe]):g}", fontsize=9
    )
    for axes in (by_zeta, drift):
        axes.set_title(rf"$\Delta V/V$ = {step:g}", fontsize=9)
    for axes in (by_step, by_zeta):
        axes.axhline(1.0, **THEORY)
        axes.set_ylim(0, 4)
        axes.set_ylabel(r"diffusivity $D = \langle\delta^2\rangle / \Delta V$")
    drift.axhline(0.0, **THEORY)
    drift.set_ylim(-2, 3)
    drift.set_ylabel(r"drift $\mu = \langle\delta\rangle \sqrt{V} / \Delta V$")
    for axes in (by_step, by_zeta, drift):
        axes.set_xlim(0, 3)
        axes.set_xlabel(r"$p / \sqrt{V}$ before the ring")
    by_step.legend(fontsize=7)
    drift.legend(fontsize=7)
    return figure


def fluxes(dataset: xr.Dataset) -> Figure:
    """Area lost and entered over the contact area, their ratio, and the net, against the step, at the last probe."""
    figure, (both, ratio, net) = new_figure(width=11.0, height=3.8, columns=3)
    steps = dataset.relative_step.values
    hurst, probe = dataset.sizes["hurst"] - 1, dataset.sizes["probe"] - 1
    at = dataset.isel(hurst=hurst)
    lost, entered = (Spread.of(reading.flux(at, name).isel(probe=probe)) for name in ("lost", "entered"))
    share = Spread.of((reading.flux(at, "entered") / reading.flux(at, "lost")).isel(probe=probe))
    change = Spread.of(reading.net_flux(at).isel(probe=probe))
    for j, load in enumerate(dataset.reduced_pressure.values):
        label = f"p* = {load:g}"
        both.errorbar(steps, lost.value[j], yerr=lost.half_width[j], label=label, **look(j))
        both.errorbar(
            steps, entered.value[j], yerr=entered.half_width[j], ls="--", **{**look(j), "mfc": "white"}
        )
        ratio.errorbar(np.sqrt(steps), share.value[j], yerr=share.half_width[j], label=label, **look(j))
        net.errorbar(steps, change.value[j], yerr=change.half_width[j], label=label, **look(j))
    guide = float(lost.value[0, -1])
    both.plot(
        steps, guide * np.sqrt(steps / steps[-1]), color="black", lw=0.8, ls=":", label=r"$\sqrt{\Delta V}$"
    )
    both.plot([], [], color="black", ls="--", label="entered (full lines: lost)")
    both.plot([], [], **THEORY, label="Persson, light load")
    both.set_xscale("log")
    both.set_yscale("log")
    both.set_ylabel("area over p = 0 / contact area")
    ratio.axhline(1.0, color="black", lw=0.8, ls=":")
    ratio.set_xlim(left=0)
    ratio.set_ylabel("entered / lost")
    net.axhline(-0.5, **THEORY)
    net.set_xscale("log")
    net.set_ylabel(r"$d\,\ln A / d\,\ln V$ (located area)")
    ratio.set_xlabel(r"$\sqrt{\Delta V / V}$")
    for axes in (both, net):
        axes.set_xlabel(r"$\Delta V / V$ of the ring")
    handles, labels = both.get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=7, ncols=7, loc="outside lower center")
    return figure


def budget_bars(dataset: xr.Dataset) -> Figure:
    """Draw the book of the mean square pressure by octave, at every load, both H side by side."""
    loads = dataset.sizes["load"]
    figure, panels = new_figure(width=max(5.0, 2.9 * loads), height=4.0, columns=loads)
    book = reading.square_book(dataset)
    octaves = np.asarray(dataset.attrs["octaves"], dtype=float)
    count = dataset.sizes["hurst"]
    for j, axes in enumerate(panels):
        for h in range(count):
            place = np.arange(octaves.size - 1) + (h - (count - 1) / 2) * 0.8 / count
            _stack(axes, book.isel(hurst=h, load=j), place, width=0.72 / count, first=j == 0 and h == 0)
        axes.set_xticks(np.arange(octaves.size - 1), [f"{a:g}-{b:g}" for a, b in itertools.pairwise(octaves)])
        axes.axhline(0, color="black", lw=0.6)
        axes.axhline(1, **THEORY)
        axes.set_ylim(-1.2, 1.9)
        axes.set_title(f"p* = {float(dataset.reduced_pressure[j]):g}", fontsize=9)
        axes.set_xlabel(r"octave of $\zeta$")
    panels[0].set_ylabel(r"$d\langle p^2\rangle / (A\,dV)$ and its terms")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=7, ncols=6, loc="outside lower center")
    return figure


def _stack(axes: Axes, book: xr.Dataset, place: np.ndarray, *, width: float, first: bool) -> None:
    above, below = np.zeros(place.size), np.zeros(place.size)
    for k, (name, (words, _, _)) in enumerate(reading.TERMS.items()):
        values = Spread.of(book[name]).value.values
        bottom = np.where(values > 0, above, below)
        axes.bar(
            place,
            values,
            width,
            bottom=bottom,
            color=COLOURS[k],
            alpha=0.75,
            hatch=("", "//", "..")[k],
            edgecolor="white",
            lw=0.4,
            label=words if first else None,
        )
        above += np.maximum(values, 0)
        below += np.minimum(values, 0)
    change = Spread.of(book["change"])
    axes.errorbar(
        place,
        change.value,
        yerr=change.half_width,
        ls="",
        marker="o",
        ms=4,
        color="black",
        mfc="white",
        capsize=2,
        label="sum" if first else None,
    )


def area_and_restarts(dataset: xr.Dataset) -> Figure:
    """Draw A over Persson's along zeta, and where absorbing diffusion goes from the truth, at every load."""
    loads = dataset.sizes["load"]
    figure, panels = new_figure(width=max(5.0, 2.9 * loads), height=3.8, columns=loads)
    over, restarted = reading.over_persson(dataset), reading.restarts(dataset)
    zeta = dataset.zeta.values
    for j, axes in enumerate(panels):
        for h, exponent in enumerate(dataset.hurst.values):
            truth = Spread.of(over.isel(hurst=h, load=j))
            axes.errorbar(
                zeta,
                truth.value,
                yerr=truth.half_width,
                label=f"simulated, H = {exponent:g}",
                **{**look(h), "ms": 3, "capsize": 1},
            )
            for r in range(dataset.sizes["restart"]):
                line = Spread.of((over * restarted.isel(restart=r)).isel(hurst=h, load=j)).value
                label = "diffusion from the truth" if r == 0 else None
                axes.plot(zeta, line, color=COLOURS[h], ls="--", lw=0.9, label=label)
        axes.axhline(1.0, **THEORY)
        axes.set_xscale("log", base=2)
        axes.set_title(f"p* = {float(dataset.reduced_pressure[j]):g}", fontsize=9)
        axes.set_xlabel(r"$\zeta = q/q_{long}$")
    panels[0].set_ylabel(r"$A$ over Persson's")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=7, ncols=min(4, loads), loc="outside lower center")
    return figure


def memory(dataset: xr.Dataset) -> Figure:
    """Chance to be brought back into contact by the number of rings since leaving."""
    figure, panels = new_figure(
        width=3.6 * dataset.sizes["hurst"] + 1.4, height=3.7, columns=dataset.sizes["hurst"]
    )
    chance = reading.returns(dataset)
    for h, axes in enumerate(panels):
        for j, load in enumerate(dataset.reduced_pressure.values):
            at = Spread.of(chance.isel(hurst=h, load=j))
            shown = np.arange(1, at.value.size)
            axes.errorbar(shown, at.value[1:], yerr=at.half_width[1:], label=f"p* = {load:g}", **look(j))
            axes.axhline(float(at.value[0]), color=COLOURS[j], ls=":", lw=0.9)
        axes.set_yscale("log")
        axes.set_title(f"H = {float(dataset.hurst[h]):g}", fontsize=9)
        axes.set_xlabel("rings since leaving (dotted: never in contact)")
    panels[0].set_ylabel("chance that the next ring brings it back")
    panels[0].legend(fontsize=7)
    return figure
