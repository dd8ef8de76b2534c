"""Error of the contact area against what it costs. It reads the dataset and never solves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from validation.report.figure import COLOURS, new_figure, plain_look

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

__all__ = ["error_against_cost"]


def error_against_cost(
    dataset: xr.Dataset,
    error: NDArray[np.float64],
    fronts: Mapping[str, Sequence[int]],
    *,
    alike: NDArray[np.bool_],
) -> Figure:
    """Error against seconds for every way, and against memory for those measured alike, with Pareto fronts."""
    figure, panels = new_figure(width=9.5, columns=2, height=5.6)
    groups: dict[str, list[int]] = {}
    for k, label in enumerate(dataset.label.values.tolist()):
        name = label.split(",")[0] + (", 4 shifts" if label.endswith("shifts") else "")
        groups.setdefault(name, []).append(k)
    floor = 100 * float(np.sqrt((dataset.reference_error**2).mean()))
    for axes, (cost, unit) in zip(panels, (("seconds", 1.0), ("peak_bytes", 2.0**20)), strict=True):
        price = dataset[cost].values / unit
        for g, (name, group) in enumerate(groups.items()):
            ways = group if cost == "seconds" else [k for k in group if alike[k]]
            style = {**plain_look(g), "mfc": "white" if g >= 8 else COLOURS[g % 8]}
            axes.plot(price[ways], 100 * error[ways], ls="", label=name, **style)
        best = list(fronts[cost])
        axes.plot(price[best], 100 * error[best], color="black", lw=0.8, label="Pareto front")
        axes.axhspan(min(floor, 100 * float(error.min())) / 3, floor, color="black", alpha=0.1, lw=0)
        axes.set_xscale("log")
        axes.set_yscale("log")
    panels[0].set_xlabel("processor time for one surface [s]")
    panels[1].set_xlabel("memory of the largest solve [MiB]")
    panels[0].set_ylabel("rms error of the contact area [%]")
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, fontsize=7, ncols=5, loc="outside lower center")
    return figure
