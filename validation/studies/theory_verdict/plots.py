"""Figure of the verdict on the theory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from validation.report.figure import COLOURS, look, new_figure
from validation.report.words import mathtext
from validation.studies.theory_verdict.words import labels

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["theory_verdict"]


def theory_verdict(dataset: xr.Dataset, words: Sequence[str]) -> Figure:
    """Draw simulated over predicted values against the simulated area, one panel for each quantity."""
    figure, panels = new_figure(width=3.2 * len(words), height=4.0, columns=len(words))
    for q, (axes, title) in enumerate(zip(panels, words, strict=True)):
        for v, name in enumerate(labels(dataset)):
            ratio, half = dataset.ratio[q, v], dataset.interval[q, v]
            # A ratio of two vanishing gaps is drawn by nobody's eye: leave out what is not known to a factor of two.
            known = np.isfinite(ratio.values) & (half.values < 0.5)
            if known.any():
                axes.errorbar(
                    dataset.area[known],
                    ratio[known],
                    yerr=half[known],
                    label=name,
                    lw=1,
                    **look(v),
                )
        axes.axhline(1, color="black", lw=1)
        axes.set_xscale("log")
        axes.set_xlabel(r"simulated $A/A_0$")
        axes.set_title(mathtext(title), fontsize=9)
    theory = dataset.theory_area.sel(variant="persson")
    ensemble = dataset.ratio[0, 0] * theory.sel(mode="conditional") / theory.sel(mode="ensemble")
    panels[0].plot(dataset.area, ensemble, color=COLOURS[0], ls="--", lw=0.7, label="Persson, C(q) alone")
    panels[0].set_ylabel("simulated over predicted")
    panels[0].legend(fontsize=7)
    return figure
