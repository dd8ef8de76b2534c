"""Gold numbers of the studies with the longest ladders, computed anew."""

import pytest
from gold.asked import LADDERS
from gold.check import disagreements

from validation.solves.bench import Bench

NAMES = LADDERS


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """One store, whose solves the studies share."""
    return Bench.at(tmp_path_factory.mktemp("gold") / "solves")


@pytest.mark.parametrize("name", NAMES)
def test_the_numbers_are_those_of_the_gold_file(name, bench, tmp_path):
    assert disagreements(name, bench, tmp_path) == []
