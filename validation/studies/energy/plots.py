"""Figures of the study of the energy."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from validation.report.figure import STYLES, look, new_figure
from validation.report.words import mathtext
from validation.studies.energy.words import QUANTITIES, scored

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["ratios", "towards_full_contact"]


def ratios(dataset: xr.Dataset) -> Figure:
    """Draw simulated over predicted values over the area, one panel for each quantity."""
    figure, panels = new_figure(width=11.0, height=4.2, columns=len(QUANTITIES))
    area = dataset.area.mean("surface").values
    for axes, (name, words) in zip(panels, QUANTITIES.items(), strict=True):
        found = scored(dataset, name)
        for v, theory in enumerate(dataset.theory.values):
            known = np.isfinite(found.ratio[v]) & (found.interval[v] < found.ratio[v])
            axes.errorbar(
                area[known],
                found.ratio[v][known],
                yerr=found.interval[v][known],
                label=str(theory),
                lw=1,
                **look(v),
            )
        axes.axhline(1, color="black", lw=1)
        axes.set_yscale("log")
        axes.set_xlabel(r"$A/A_0$")
        axes.set_title(mathtext(words), fontsize=9)
    panels[0].set_ylabel("simulated over predicted")
    panels[0].legend(fontsize=7)
    return figure


def towards_full_contact(dataset: xr.Dataset) -> Figure:
    """Draw each quantity over the area that is not in contact."""
    figure, panels = new_figure(width=11.0, height=4.2, columns=len(QUANTITIES))
    partial = dataset.gap.values.max(axis=0) > 0
    out = (1 - dataset.area.mean("surface").values)[partial]
    for axes, (name, words) in zip(panels, QUANTITIES.items(), strict=True):
        found = scored(dataset, name)
        missing = name == "energy"
        value = 1 - found.value if missing else found.value
        predicted = dataset[f"theory_{name}"].values
        predicted = 1 - predicted if missing else predicted
        axes.errorbar(
            out,
            value[partial],
            yerr=found.half_width[partial],
            ls="",
            marker="o",
            ms=4,
            color="black",
            label="boundary elements",
        )
        for v, theory in enumerate(dataset.theory.values):
            line = np.where(predicted[v] > 0, predicted[v], np.nan)[partial]
            axes.plot(
                out,
                line,
                lw=1,
                color=look(v)["color"],
                ls=STYLES[v % len(STYLES)],
                label=str(theory),
            )
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel(r"$1 - A/A_0$")
        axes.set_title(mathtext(f"1 - {words}" if missing else words), fontsize=9)
    panels[0].legend(fontsize=7)
    return figure
