"""Whether limits hold on surfaces that had no part in their law of error."""

import numpy as np
import pytest
from area_cases import KINDS, SHAPES, Case
from area_law import LADDERS, TRUTH, coverage, limit_of, measured

from fem_contact import located_limit, perimeter_limit

#: Seeds that no fit has seen: those of `area_law.py` are below 10,000.
FRESH = 20_000


#: How many of each kind, and most shortest waves on the period.
_SURFACES = {"elastic": (100, 16), "hardness": (40, 16), "elements": (40, 16)}


#: First seeds of a few that are unlike each other: a cone, absolute values, steps, a ridge and a wedge.
FIRST = {"stretched": FRESH, "smooth": FRESH, "kinked": FRESH + 9}


@pytest.mark.parametrize("kind", ["stretched", "smooth", pytest.param("kinked", marks=pytest.mark.slow)])
def test_claims_hold_on_a_few_surfaces_unlike_those_of_the_law(kind):
    """By the law of isotropic Gaussian surfaces alone they held 40 to 80 %, and were up to 50 errors off."""
    off, share = np.moveaxis(coverage(kind, 5, FIRST[kind]), -1, 0)
    # Steps have no limit, nor have kinks on one grid.
    off = off[np.isfinite(share)]
    assert off.size >= 24
    assert np.mean(np.abs(off) < 2) >= 0.9
    assert np.max(np.abs(off)) < 4


@pytest.mark.slow
@pytest.mark.parametrize("kind", SHAPES)
def test_two_standard_errors_hold_on_surfaces_unlike_those_of_the_law(kind):
    off, share = np.moveaxis(coverage(kind, 12 if kind == "wide" else 60, FRESH), -1, 0)
    off = off[np.isfinite(share)]
    assert np.mean(np.abs(off) < 2) >= 0.93
    # Claims at kinks are two to three times as wide as they need be.
    assert (0.2 if kind == "kinked" else 0.4) < np.sqrt(np.mean(np.square(off))) < 1.15


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_two_standard_errors_hold_the_limit_of_finer_grids_on_fresh_surfaces(kind):
    surfaces, waves = _SURFACES.get(kind, (20, 8))
    cases = [Case.drawn(FRESH + k, kind=kind, waves=waves) for k in range(surfaces)]
    limit = located_limit if kind == "elastic" else perimeter_limit
    # Where edges are corrected by a constant, scenes ask for two grids.
    ladders = [ladder for ladder in LADDERS if kind == "elastic" or len(ladder) > 1]
    misses = []
    for case in cases:
        areas = measured(case, {3: 2, 4: 2, 6: 2, 8: 2, 12: 1, 16: 1} | dict.fromkeys(TRUTH, 1))
        truth = limit([area for level in TRUTH for area in areas[level]])
        misses += [limit_of(areas, ladder, limit=limit, truth=truth)[0] for ladder in ladders]
    # Ladders of one surface are not independent: the share of 100 surfaces has a deviation of 2 %.
    held = np.mean(np.abs(misses) < 2)
    assert held >= 0.93
    # Wide enough, and not wider: what is off is of the size that is claimed.
    assert 0.4 < np.sqrt(np.mean(np.square(misses))) < 1.15
