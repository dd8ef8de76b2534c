"""Intervals hold what was planted as often as they say, and findings turn where their intervals end."""

import numpy as np
import pytest
import xarray as xr

from validation.report.estimates import NORMAL, claim, derive, mean, total_error
from validation.report.findings import KINDS, finding, ranking
from validation.report.values import Value
from validation.theories.predicted import COMPARED, distances, ranked

PLANTS, TRUTH = 10_000, 0.3


def normal(seed, *shape):
    return np.random.default_rng(seed).standard_normal(shape)


def assert_hold(data, name, truth):
    """95 % of the intervals hold the truth, within three standard errors of that share."""
    held = np.mean(abs(data[name] - truth) <= total_error(data, name))
    assert abs(float(held) - 0.95) < 3 * (0.95 * 0.05 / PLANTS) ** 0.5, name


@pytest.mark.parametrize(("surfaces", "pairs"), [(3, False), (8, False), (8, True)])
def test_the_interval_over_surfaces_holds_the_planted_mean(surfaces, pairs):
    noise = normal(surfaces, surfaces, PLANTS)
    if pairs:  # +h and -h err to opposite sides, for the most part
        noise[1::2] = 0.2 * noise[1::2] - 0.9 * noise[::2]
    data = xr.Dataset({"area_each": (("surface", "load"), TRUTH + 0.02 * noise)})
    assert_hold(mean(data, "area", pairs=pairs), "area", TRUTH)


def test_errors_of_several_sources_and_variables_combine_to_intervals_that_hold():
    grid, solver, other = normal(1, 3, PLANTS)
    data = xr.Dataset({"area": ("load", TRUTH + 0.003 * grid + 0.002 * solver)})
    data = data.assign(area_persson=("load", 0.2 + 0.001 * other))
    data = claim(data, "area", grid=NORMAL * 0.003, solver=NORMAL * 0.002)
    data = claim(data, "area_persson", grid=NORMAL * 0.001, solver="it is exact")
    data = derive(data, area_ratio="area / area_persson", area_excess="log(area / area_persson)")
    for name, truth in {"area": TRUTH, "area_ratio": TRUTH / 0.2, "area_excess": np.log(1.5)}.items():
        assert_hold(data, name, truth)


_SIGNS = {(1.0, 1.0): "0", (1.1, 1.0): "+", (-1.0, 1.0): "0", (-1.1, 1.0): "-", (1.0, np.nan): "?"}
#: By kind that decides: outcomes at each threshold and beyond, by value and half width.
TURNS = {
    "comparison": _SIGNS,
    "trend": _SIGNS,
    "agreement": {(1.0, 1.0): "agree", (1.1, 1.0): "differ", (-1.0, 1.0): "agree", (-1.1, 1.0): "differ"},
    "equivalence": {
        (0.6, 0.3): "within",
        (0.75, 0.25): "undecided",
        (1.2, 0.3): "undecided",
        (1.25, 0.25): "beyond",
        (-0.6, 0.3): "within",
        (-1.25, 0.25): "beyond",
        (0.0, np.nan): "?",
    },
}


def test_each_kind_of_finding_turns_at_its_threshold_from_both_sides():
    assert set(TURNS) == {kind for kind, (rule, _) in KINDS.items() if rule is not None}
    for kind, turns in TURNS.items():
        for (value, error), outcome in turns.items():
            found = finding(kind, "{verdict}", by="x", x=Value(value=value, error=error))
            assert (found.outcomes, found.text) == ((outcome,), KINDS[kind][1][outcome]), (kind, value)


@pytest.mark.parametrize(("apart", "sign"), [(0.9, "="), (1.1, "<")])
def test_what_is_ranked_lies_apart_by_more_than_the_interval_of_the_difference(apart, sign):
    ranked = {"b": Value(value=1 + 0.05 * apart, error=0.04), "a": Value(value=1.0, error=0.03)}
    words = ranking("{order}", ranked, lambda one, other: {"ab": 0.05}[one + other]).text.split()
    assert (words[0], sign in words, "b" in words) == ("a", True, True)


@pytest.mark.parametrize(("logs", "ordered"), [((0.2, -0.2), 0.05), ((0.4, 0.41), 1.0), ((-0.4, -0.41), 1.0)])
def test_theories_scored_by_one_simulation_are_ordered_by_what_its_error_does_to_both(logs, ordered):
    # Equally far on opposite sides: as often as intervals may miss. On one side: always, and as planted.
    plants, error = 400 if ordered < 1 else 50, 0.08
    over = np.exp(error / NORMAL * normal(7, plants)[:, None] - np.array(logs))[..., None] * np.ones(2)
    data = xr.Dataset({"area": ("load", [0.1, 0.2])}, coords={"theory": ["a", "b"]})
    for name in COMPARED:
        data = data.assign({f"{name}_over": (("plant", "theory", "load"), over)})
        data = claim(data, f"{name}_over", grid=error * data[f"{name}_over"])
    data = distances(data)
    orders = [ranked("{order}", data.isel(plant=k), "area").values["order"].value for k in range(plants)]
    share = np.mean(["<" in order for order in orders])
    assert abs(share - ordered) <= 3 * (ordered * (1 - ordered) / plants) ** 0.5
    assert ordered < 1 or all(order.startswith("a ") for order in orders)
