"""How far is the modulus that a wave feels by Persson's theory from the exact one?

The theory weights E(z) with the decay of the wave (Persson 2006, Sec. 5) and claims to be right where E
changes little over 1/q, E'/(E q) < 1. Boundary elements take the exact compliance of the layered solid.
"""

from collections.abc import Callable
from typing import Self

import numpy as np
import xarray as xr
from pydantic import Field, model_validator

from fem_contact.graded import ExponentialSolid, LayeredSolid
from fem_contact.response import Response
from fem_contact.solid import Solid
from persson.graded import ExponentialLayers, SurfaceLayer
from validation.arrays import Array
from validation.report.estimates import derive
from validation.report.views import Figure, Table, Views, against, finding
from validation.studies._options import Positives, StudyOptions
from validation.studies._study import Bench
from validation.units import wrong


class Options(StudyOptions):
    """Which solids, and which waves."""

    why_no_scene = "it asks about single waves, and presses nothing"

    ratios: Positives = (0.1, 0.25, 0.5, 2.0, 4.0, 10.0)
    """modulus far below over that of the surface, and of the solid over that of the coating; not 1"""
    poisson: float = Field(default=0.3, gt=-1, le=0.5)
    """nu, the same at all depths"""
    shortest: float = Field(default=100.0, gt=1)
    """largest q d; the smallest is its inverse"""
    waves: int = Field(default=49, ge=2)
    """wavevectors, equally spaced in log q"""
    sublayers: int = Field(default=256, ge=1)
    """layers that stand for the exponential profile"""

    @model_validator(mode="after")
    def _graded(self) -> Self:
        if 1 in self.ratios:
            values = ", ".join(f"{ratio:g}" for ratio in self.ratios)
            raise wrong(f"ratios = {values}: must not be 1, which is no grading")
        return self


def run(options: Options, *, bench: Bench) -> xr.Dataset:
    """Compare the moduli wave by wave; nothing is solved.

    Over `modulus_ratio` and `reduced_wave` (q d, with the depth or thickness d): the modulus felt by the theory
    over the exact one for an exponential profile and for a coating, and the largest E'/(E q) of the profile.
    """
    if bench.plan_only:
        bench.solve([])  # says that there is nothing to solve
    q = np.geomspace(1 / options.shortest, options.shortest, options.waves)
    dims, ratios = ("modulus_ratio", "reduced_wave"), list(options.ratios)
    data = xr.Dataset(
        {
            "felt_ratio_profile": (dims, [_profile(ratio, options, q) for ratio in ratios]),
            "felt_ratio_coating": (dims, [_coating(ratio, options, q) for ratio in ratios]),
            "grading": (dims, [_grading(ratio, q) for ratio in ratios]),
        },
        coords={"reduced_wave": q, "modulus_ratio": ratios},
        attrs={"methods": "theory", "poisson": options.poisson},
    )
    worst = "({0} - 1).isel(reduced_wave=abs({0} - 1).fillna(0).argmax('reduced_wave'))"
    return derive(
        data,
        felt_error_profile=worst.format("felt_ratio_profile"),
        felt_error_coating=worst.format("felt_ratio_coating"),
        felt_error_mild=worst.format("felt_ratio_profile.where(grading < 1)"),
    )


def _profile(ratio: float, options: Options, q: Array) -> Array:
    surface = Solid(young=1.0, poisson=options.poisson)
    exact = ExponentialSolid(surface=surface, bulk_young=ratio, depth=1.0, sublayers=options.sublayers)
    weighted = ExponentialLayers(bulk=ratio, excess=[1 - ratio], depths=[1.0], poisson=options.poisson)
    return _share(weighted, exact, q)


def _coating(ratio: float, options: Options, q: Array) -> Array:
    surface, below = (Solid(young=young, poisson=options.poisson) for young in (1.0, ratio))
    exact = LayeredSolid(layers=[surface], thicknesses=[1.0], base=below)
    return _share(SurfaceLayer(bulk=ratio, layer=1.0, thickness=1.0, poisson=options.poisson), exact, q)


def _grading(ratio: float, q: Array) -> Array:
    # E'/E is monotonic in z where it is not largest at the surface.
    z = np.linspace(0.0, 30.0, 3001)
    young = ratio + (1 - ratio) * np.exp(-z)
    return float(np.max(abs(1 - ratio) * np.exp(-z) / young)) / q


def _share(felt: Callable[[Array], Array], exact: Response, q: Array) -> Array:
    return felt(q) * q * exact.compliance(q, np.zeros_like(q)) / 2


def views(data: xr.Dataset) -> Views:
    """Modulus felt over the exact one against the wavevector, and how far it is off at worst."""
    kinds = {"profile": "an exponential profile of depth d", "coating": "a layer of thickness d"}
    ends = data.isel(modulus_ratio=sorted({0, data.sizes["modulus_ratio"] - 1}))
    form = "The modulus that a wave feels is at worst off (+ is too stiff) by {each}."
    item = "{felt_error_mild:+%} where E'/(E q) < 1, {felt_error_profile:+%} over all waves and {felt_error_coating:+%} "
    item += "with a coating, whose E' is infinite, on a solid {modulus_ratio} times as stiff below"
    return Views(
        table=Table(
            ("modulus_ratio",),
            ("modulus_ratio", "felt_error_mild", "felt_error_profile", "felt_error_coating"),
        ),
        figures=[
            Figure(
                f"felt-modulus-{kind}",
                f"Modulus that a wave feels by Persson's weighting over the exact one: {profile}, for several ratios "
                "of the modulus below to that on top.",
                [against("reduced_wave", f"felt_ratio_{kind}", by="modulus_ratio", log="x")],
            )
            for kind, profile in kinds.items()
        ],
        findings=[finding("value", form, ends, item=item)],
    )
