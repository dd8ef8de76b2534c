"""Figures of the study of the load: area, gap and energy against load, and what does not change with it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from validation.measures.theory import VARIANTS
from validation.report.figure import COLOURS, THEORY, look, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from validation.measures.distributions import Distance

__all__ = ["area_against_pressure", "gap_and_energy", "load_independence"]

_LOAD = r"$p^* = p_0/(E^* h'_{rms})$"
_VARIANT_LOOKS: tuple[dict[str, Any], ...] = (
    {"color": "#38761d", "ls": "-."},
    {"color": "0.4", "ls": "--"},
    {"color": "0.4", "ls": (0, (5, 1, 1, 1))},
    {"color": "0.4", "ls": (0, (1, 1))},
)


def _variants(axes: Axes, dataset: xr.Dataset, name: str, over: NDArray[np.float64] | float = 1.0) -> None:
    """Draw a quantity of every variant that has it; the original also from C(q) alone."""
    for v, variant in enumerate(dataset.variant.values):
        values = dataset[name].sel(mode="conditional", variant=variant).values / over
        if np.isfinite(values).any():
            axes.plot(dataset.reduced_pressure, values, lw=1.2, label=VARIANTS[variant], **_VARIANT_LOOKS[v])
    ensemble = dataset[name].sel(mode="ensemble", variant="persson").values / over
    axes.plot(
        dataset.reduced_pressure,
        ensemble,
        color=THEORY["color"],
        ls="--",
        lw=0.7,
        label="Persson, C(q) alone",
    )


def area_against_pressure(dataset: xr.Dataset) -> Figure:
    """A/A0 against p*, and its ratio to the theory."""
    figure, (left, right) = new_figure(width=9.0, height=4.0, columns=2)
    persson = dataset.theory_area.sel(mode="conditional", variant="persson").values
    for axes, over in ((left, 1.0), (right, persson)):
        area = dataset.area / over
        axes.errorbar(
            dataset.reduced_pressure,
            area.mean("surface"),
            yerr=area.std("surface", ddof=1),
            ls="",
            label="simulation, limit",
            **look(0),
        )
        _variants(axes, dataset, "theory_area", over)
        axes.set_xscale("log")
        axes.set_xlabel(_LOAD)
        axes.legend(fontsize=7)
    left.set_yscale("log")
    left.set_ylabel(r"$A/A_0$")
    right.set_ylabel("area over Persson's, conditional")
    return figure


def gap_and_energy(dataset: xr.Dataset) -> Figure:
    """Mean gap, inverse stiffness and elastic energy against load, with the theory."""
    figure, panels = new_figure(width=11.0, height=3.8, columns=3)
    labels = {
        "gap": r"mean gap $/ h_{rms}$",
        "gamma": r"$p_0 / (K h_{rms})$",
        "energy": "elastic energy over that of full contact",
    }
    for k, (axes, (name, label)) in enumerate(zip(panels, labels.items(), strict=True)):
        axes.errorbar(
            dataset.reduced_pressure,
            dataset[name].mean("surface"),
            yerr=dataset[name].std("surface", ddof=1),
            ls="",
            label="simulation",
            **look(k),
        )
        _variants(axes, dataset, f"theory_{name}")
        axes.set_ylabel(label)
        axes.set_xscale("log")
        axes.set_xlabel(_LOAD)
    panels[2].set_yscale("log")
    panels[0].legend(fontsize=7)
    return figure


def load_independence(
    dataset: xr.Dataset, distances: Mapping[str, Distance], theory: NDArray[np.float64], reference: int
) -> Figure:
    """Draw the distributions per contact area at several loads, and how far they are from that at the reference load."""
    figure, (left, middle, right) = new_figure(width=11.0, height=3.8, columns=3)
    area = dataset.area.mean("surface").values
    last = max(reference + 1, int(np.sum(area < 0.9)))
    shades = np.linspace(0.75, 0.0, max(1, last - reference))
    for k, j in enumerate(range(reference, last)):
        stress = dataset.stress_share[:, j].sum("surface").values
        patches = dataset.patch_area_share[:, j].sum("surface").values
        style: dict[str, Any] = {"color": str(shades[k]), "ls": ("-", "--", "-.", ":")[k % 4], "lw": 1.1}
        width = np.diff(np.concatenate([[0.0], dataset.stress_upper.values]))
        density = (stress / stress.sum() / width).reshape(-1, 4).mean(axis=1)
        left.plot(
            dataset.stress_upper.values.reshape(-1, 4).mean(axis=1),
            density,
            label=f"A/A0 = {area[j]:.2g}",
            **style,
        )
        middle.plot(dataset.patch_upper, np.cumsum(patches) / patches.sum(), **style)
    left.set_xlim(0, 2.5)
    left.set_ylim(bottom=0)
    left.set_xlabel(r"$\sigma / (E^* h'_{rms})$")
    left.set_ylabel(r"$P(\sigma)\,E^* h'_{rms}\,A_0/A$")
    left.legend(fontsize=7)
    middle.set_xscale("log")
    middle.set_xlabel(r"$A_{patch} / \lambda_{short}^2$")
    middle.set_ylabel("share of the contact area in smaller patches")
    for k, (name, distance) in enumerate(distances.items()):
        # A bootstrap interval need not hold the value itself, which is the least of its kind.
        bars = np.maximum([distance.value - distance.low, distance.high - distance.value], 0.0)
        right.errorbar(area, distance.value, yerr=bars, ls="-", label=name, **look(k))
        right.plot(area, distance.noise, color=COLOURS[k], ls=":", lw=0.8)
    right.plot(area, theory, label="pressure, Persson's own", **THEORY)
    right.set_xscale("log")
    right.set_xlabel(r"$A/A_0$")
    right.set_ylabel(f"distance from A/A0 = {area[reference]:.2g}")
    right.set_ylim(0, 0.5)
    right.legend(fontsize=7)
    return figure
