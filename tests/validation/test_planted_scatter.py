"""Scatter of surfaces that is known in every study: none among copies, and that of a sample told twice."""

from unittest.mock import patch

import numpy as np
import pytest
import scipy.special
from gold.asked import STUDIES
from gold.make import options_of
from numpy.testing import assert_allclose

from validation.report.estimates import HOLDS
from validation.scenes.tables import RandomSurface

#: Options that say how many surfaces, or pairs of them, are pressed.
COUNTS = ("surfaces", "pairs", "ladder_pairs", "method_pairs", "probe_surfaces")
#: `archard` moves its surfaces, `reference` regresses on theirs; the others take no mean over surfaces.
NOT_ASKED = ("archard", "reference", "accuracy-cost", "scaling")
COUNTED = [name for name, told in STUDIES.items() if set(COUNTS) & told.keys()]
ASKED = [name for name in COUNTED if " " not in name and name not in NOT_ASKED]
#: Twice their surfaces take as long as those of all others; of them it is asked that copies do not scatter.
LONG = ("adhesion", "autopsy")
#: More of the small samples are pressed than of the large ones.
UNEQUAL = "kappa_by_size"


def repeated(name, bench, folder, *, distinct, times):
    """Compute a study on `times` as many surfaces, of which the first `distinct` come again and again."""
    told = STUDIES[name]
    study, options, _ = options_of(name, folder, **{n: told[n] * times for n in COUNTS if n in told})
    first = options.first.surface.seed if "scene" in told else options.seed

    def seed_of(surface, realisation):
        return first + (surface.seed + realisation - first) % distinct

    with patch.object(RandomSurface, "seed_of", seed_of):
        return study.compute(options, bench=bench)


def of_surfaces(data):
    """Half widths that come from the scatter of surfaces, not from that of points about a line."""
    found = {}
    for name, error in data.data_vars.items():
        scatter = "surfaces" in error.coords.get("source", []) and "surface" not in error.dims
        if scatter and "fit" not in error.attrs.get(HOLDS, ""):
            found[str(name).removesuffix("_error")] = error.sel(source="surfaces")
    return found


@pytest.mark.parametrize("name", ASKED)
def test_copies_of_one_surface_have_no_scatter(name, bench, tmp_path):
    data = repeated(name, bench, tmp_path, distinct=1, times=1)
    for variable, half in of_surfaces(data).items():
        largest = abs(data[variable]).fillna(0.0).max()
        assert np.all(half.fillna(0.0) <= 1e-12 * largest), variable
        made, each = data[variable].attrs, data.get(f"{variable}_each")
        if each is not None and made.get("reduction") == "mean":
            first = each[{made["over"]: slice(1 + made["pairs"])}].mean(made["over"])
            assert_allclose(data[variable], first, rtol=1e-12, err_msg=variable)


@pytest.mark.parametrize("name", [name for name in ASKED if name not in LONG])
def test_a_sample_told_twice_keeps_its_means_and_has_the_interval_of_twice_as_many(name, bench, tmp_path):
    """The sum of squares over n - 1, and Student's factor over the root of n."""
    distinct = next(STUDIES[name][key] for key in COUNTS if key in STUDIES[name])
    data = repeated(name, bench, tmp_path, distinct=distinct, times=2)
    judged = 0
    for variable, half in of_surfaces(data).items():
        made = data[variable].attrs
        if made.get("reduction") == "mean" and variable != UNEQUAL:
            samples, over = data[f"{variable}_each"], made["over"]
            if made["pairs"]:
                samples = samples.coarsen({over: 2}).mean()
            n = samples.sizes[over]
            first = samples[{over: slice(n // 2)}]
            middle = first.mean(over, skipna=False)
            assert_allclose(data[variable], middle, rtol=1e-9, atol=1e-14, err_msg=variable)
            squares = 2 * ((first - middle) ** 2).sum(over, skipna=False) / (n - 1)
            expected = scipy.special.stdtrit(n - 1, 0.975) * np.sqrt(squares / n)
            assert_allclose(half, expected, rtol=1e-6, atol=1e-12, err_msg=variable)
            judged += 1
    assert judged
