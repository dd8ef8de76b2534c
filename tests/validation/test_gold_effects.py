"""Gold numbers of the other studies, computed anew."""

import pytest
from gold.asked import AREAS, LADDERS, STUDIES
from gold.check import disagreements

from validation.solves.bench import Bench

NAMES = [name for name in STUDIES if name not in (*AREAS, *LADDERS)]


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """One store, whose solves the studies share."""
    return Bench.at(tmp_path_factory.mktemp("gold") / "solves")


@pytest.mark.parametrize("name", NAMES)
def test_the_numbers_are_those_of_the_gold_file(name, bench, tmp_path):
    assert disagreements(name, bench, tmp_path) == []
