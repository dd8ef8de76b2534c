"""Gold numbers of scenes, sweeps and results side by side, computed anew."""

import pytest
from gold.asked import COMPARED, SCENES
from gold.check import disagreements

from validation.solves.bench import Bench

NAMES = (*SCENES, *COMPARED)


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """One store, whose solves the studies share."""
    return Bench.at(tmp_path_factory.mktemp("gold") / "solves")


@pytest.mark.parametrize("name", NAMES)
def test_the_numbers_are_those_of_the_gold_file(name, bench, tmp_path):
    assert disagreements(name, bench, tmp_path) == []
