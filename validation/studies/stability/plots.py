"""The figure of the hard cases: error along every dial, by method. It reads a dataset and never solves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from validation.report.figure import look, new_figure

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["stability_figure"]

#: Where errors of rounding size, and values that were refused, are drawn.
_LEAST, _REFUSED = 1e-9, 30.0


def stability_figure(data: xr.Dataset) -> Figure:
    """Draw the error over what is allowed at every turn of every dial; crosses are refusals by name."""
    methods = list(dict.fromkeys(data["method"].values))
    figure, panels = new_figure(width=11.0, height=5.6, columns=len(methods))
    for axes, method in zip(panels, methods, strict=True):
        own = data.isel(row=data["method"].values == method)
        for k, name in enumerate(dict.fromkeys(own["case"].values)):
            case = own.isel(row=own["case"].values == name)
            turn = np.arange(1, case.sizes["row"] + 1)
            share = np.maximum((case["error"] / case["bound"]).values, _LEAST)
            style = look(k) | {"mfc": None if k < 8 else "white"}
            axes.errorbar(turn, share, lw=1, label=str(name), **style)
            refused = case["outcome"].values == "refused"
            axes.plot(turn[refused], np.full(refused.sum(), _REFUSED), "x", color=style["color"], ms=7)
        axes.axhline(1.0, color="black", lw=1, label="allowed")
        axes.set_yscale("log")
        axes.set_ylim(_LEAST / 3, 4 * _REFUSED)
        axes.set_title(str(method).upper() if method in ("bem", "fem") else str(method), fontsize=10)
        axes.set_xlabel("turn of the dial, from easy to hard")
        axes.legend(fontsize=6, ncol=2, loc="upper center", bbox_to_anchor=(0.5, -0.14))
    panels[0].set_ylabel("error over what is allowed (x: refused by name)")
    return figure
