"""How far is the modulus that a wave feels by Persson's theory from the exact one?

The theory weights E(z) with the decay of the wave (Persson 2006, Sec. 5) and claims to be right where E
changes little over 1/q, E'/(E q) < 1. Boundary elements take the exact compliance of the layered solid.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fem_contact.graded import ExponentialSolid, LayeredSolid
from fem_contact.response import Response
from fem_contact.solid import Solid
from persson.graded import ExponentialLayers, SurfaceLayer
from validation.errors import UsageError

if TYPE_CHECKING:
    import xarray as xr

    from validation.report.drawing import Drawing
    from validation.solves.bench import Bench

__all__ = ["figures", "findings", "run"]

Array = NDArray[np.float64]


def run(
    *,
    bench: Bench | None = None,
    ratios: tuple[float, ...] = (0.1, 0.25, 0.5, 2.0, 4.0, 10.0),
    poisson: float = 0.3,
    shortest: float = 100.0,
    waves: int = 49,
    sublayers: int = 256,
) -> xr.Dataset:
    """Compare the moduli wave by wave.

    Parameters
    ----------
    bench : Bench, optional
        Runs no solve, as nothing is solved; one that only plans is obeyed.
    ratios : tuple of float
        Modulus far below over that of the surface; of the solid over that of the coating.
    poisson : float
        nu, the same at all depths.
    shortest : float
        Largest q d; the smallest is its inverse.
    waves, sublayers : int
        Wavevectors, and layers that stand for the exponential profile.

    Returns
    -------
    xarray.Dataset
        Over `ratio` and `wave` (q d, with the depth or thickness d): the modulus felt by the theory over the
        exact one for an exponential profile and for a coating, and the largest E'/(E q) of the profile.

    Raises
    ------
    UsageError
        For ratios that are not positive or 1, or a `shortest` not above 1.
    """
    import xarray as xr

    if not all(ratio > 0 and ratio != 1 for ratio in ratios):
        raise UsageError(f"--ratios = {ratios}: must be positive and not 1, which is no grading")
    if not shortest > 1 or waves < 2:
        raise UsageError(f"--shortest = {shortest!r}, --waves = {waves}: must exceed 1")
    if bench is not None and bench.plan_only:
        bench.solve([])
    q = np.geomspace(1 / shortest, shortest, waves)
    surface = Solid(young=1.0, poisson=poisson)
    profile, coating, grading = [], [], []
    for ratio in ratios:
        below = Solid(young=ratio, poisson=poisson)
        exact = ExponentialSolid(surface=surface, bulk_young=ratio, depth=1.0, sublayers=sublayers)
        weighted = ExponentialLayers(bulk=ratio, excess=[1 - ratio], depths=[1.0], poisson=poisson)
        profile.append(_share(weighted, exact, q))
        layered = LayeredSolid(layers=[surface], thicknesses=[1.0], base=below)
        layer = SurfaceLayer(bulk=ratio, layer=1.0, thickness=1.0, poisson=poisson)
        coating.append(_share(layer, layered, q))
        # E'/E of E = bulk + (1 - bulk) exp(-z) is monotonic in z where it is not largest at the surface.
        z = np.linspace(0.0, 30.0, 3001)
        young = ratio + (1 - ratio) * np.exp(-z)
        grading.append(float(np.max(abs(1 - ratio) * np.exp(-z) / young)) / q)
    words = "felt modulus over exact"
    one = {"units": "1"}
    return xr.Dataset(
        {
            "profile": (("ratio", "wave"), profile, one | {"long_name": f"{words}, profile"}),
            "coating": (("ratio", "wave"), coating, one | {"long_name": f"{words}, coating"}),
            "grading": (("ratio", "wave"), grading, one | {"long_name": "largest E'/(E q)"}),
        },
        coords={
            "wave": ("wave", q, one | {"long_name": "q d"}),
            "ratio": ("ratio", list(ratios), one | {"long_name": "modulus below over that on top"}),
        },
        attrs={"methods": "theory bem", "poisson": poisson},
    )


def _share(felt: Callable[[Array], Array], exact: Response, q: Array) -> Array:
    """Return the modulus felt over the exact one, 2 / (q C(q))."""
    return np.asarray(felt(q) * q * exact.compliance(q, np.zeros_like(q)) / 2)


def findings(data: xr.Dataset) -> tuple[str, ...]:
    """Say for every contrast how wrong the weighting is, inside the range it claims and outside."""
    from validation.comparison.findings import percent

    sentences = []
    for k, ratio in enumerate(data["ratio"].values):
        share, inside = data["profile"].values[k] - 1, data["grading"].values[k] < 1
        text = f"Below {ratio:g} times as stiff as on top: "
        text += (
            f"{percent(_worst(share[inside]))} off at worst where E'/(E q) < 1"
            if inside.any()
            else "no wave has E'/(E q) < 1"
        )
        text += f", {percent(_worst(share))} over all waves; " if not inside.all() else "; "
        text += f"a coating, whose E' is infinite, {percent(_worst(data['coating'].values[k] - 1))}"
        sentences.append(text + " (+ is too stiff).")
    return tuple(sentences)


def _worst(errors: Sequence[float] | Array) -> float:
    values = np.asarray(errors)
    return float(values[np.argmax(np.abs(values))])


def figures(data: xr.Dataset) -> tuple[Drawing, ...]:
    """Draw the ratio of the moduli against the wavevector."""
    from validation.report.drawing import Drawing
    from validation.report.figure import lines_figure

    return tuple(
        Drawing(
            name=f"felt-modulus-{kind}",
            figure=lines_figure(data, x="wave", lines=(kind,), along="ratio", logarithmic="x"),
            data=data[[kind, "grading"]],
            caption=f"Modulus that a wave feels by Persson's weighting over the exact one: {words}, for "
            "several ratios of the modulus below to that on top.",
        )
        for kind, words in (
            ("profile", "exponential profile of depth d"),
            ("coating", "layer of thickness d"),
        )
    )
