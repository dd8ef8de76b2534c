"""Figures of the study of adhesion by magnification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from validation.measures.adhesive import STRESS_EDGES
from validation.measures.common import draw_means, means_of
from validation.report.figure import COLOURS, new_figure
from validation.studies.adhesive_magnification.words import TOLD, estimate, solved, theory

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["by_magnification", "stress"]


def by_magnification(dataset: xr.Dataset) -> Figure:
    """Draw area, force and energy over the magnification, with the theory."""
    figure, panels = new_figure(width=11.0, height=4.2, columns=3)
    zetas = dataset.magnification.values
    done = solved(dataset)
    for axes, name in zip(panels, ("contact", "force", "energy"), strict=True):
        for told, words in enumerate(TOLD.values()):
            at = [z for t, z in done if t == told]
            if not at:
                continue
            draw_means(
                axes,
                zetas[at],
                [estimate(dataset, name, told, z) for z in at],
                ls="",
                marker="o",
                color=COLOURS[told],
                mfc="white" if told else COLOURS[told],
                label=f"solved with {words}".replace("effective work", r"$\gamma_\mathrm{eff}(\zeta)$"),
            )
            said = np.array([theory(dataset, name, told, z) for z in at])
            for r, reading in enumerate(("Eqs. 44-49", "Eq. 43")):
                if np.isfinite(said[:, r]).any():
                    style = ":" if told else ("--", "-.")[r]
                    label = "theory, one solution" if told else f"theory, {reading}"
                    axes.plot(zetas[at], said[:, r], color=COLOURS[told], ls=style, lw=1.2, label=label)
        axes.set_xscale("log", base=2)
        axes.set_xlabel(r"magnification $\zeta$ of the last wave")
    plain = [estimate(dataset, "plain", 0, z).value for z in range(zetas.size)]
    panels[0].plot(zetas, plain, color="black", lw=0.8, marker="x", label="without adhesion")
    panels[0].set_ylabel(r"$A/A_0$")
    panels[1].set_ylabel(r"$F / F_\mathrm{load}$")
    panels[2].set_ylabel(r"$U_\mathrm{el} / U_\mathrm{full}$")
    panels[0].legend(fontsize=7)
    return figure


def stress(dataset: xr.Dataset) -> Figure:
    """Draw P(sigma) at the first and the last magnification, and the energy of the waves."""
    figure, (first, last, waves) = new_figure(width=11.0, height=4.2, columns=3)
    middle = (STRESS_EDGES[1:] + STRESS_EDGES[:-1]) / 2
    width = np.diff(STRESS_EDGES)
    for axes, z in ((first, 0), (last, dataset.sizes["magnification"] - 1)):
        ours = dataset.stress.values[0, :, z].sum(axis=0)
        axes.step(
            middle, ours / ours.sum() / width, where="mid", color=COLOURS[0], lw=1, label="boundary elements"
        )
        for r, (ls, reading) in enumerate((("--", "Eqs. 44-49"), ("-.", "Eq. 43"))):
            theirs = dataset.theory_stress.values[0, :, z, r].sum(axis=0)
            if np.isfinite(theirs).all():
                axes.plot(
                    middle,
                    theirs / theirs.sum() / width,
                    color="black",
                    ls=ls,
                    lw=1,
                    label=f"theory, {reading}",
                )
        seen = middle[ours > 1e-4 * ours.sum()]
        axes.set_xlim(seen.min() - 0.1, seen.max() + 0.1)
        axes.set_title(rf"$\zeta$ = {float(dataset.magnification[z]):g}", fontsize=9)
        axes.set_xlabel(r"$\sigma / (E^* h'_\mathrm{rms})$")
    draw_means(waves, dataset.shell_end, means_of(dataset.share), marker="o", color=COLOURS[0], lw=1)
    for r, ls in enumerate(("--", "-.")):
        waves.plot(
            dataset.shell_end.values, dataset.theory_share.values[r].mean(axis=0), color="black", ls=ls, lw=1
        )
    waves.set_xscale("log", base=2)
    waves.set_xlabel(r"$\zeta$ up to which the waves reach")
    waves.set_ylabel(r"$\tilde P$ of the waves")
    first.set_ylabel(r"$P(\sigma) A_0/A \cdot E^* h'_\mathrm{rms}$")
    first.legend(fontsize=7)
    return figure
