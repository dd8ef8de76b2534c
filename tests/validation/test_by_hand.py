"""What the kit does is not done by hand: reductions, axes and long files in studies and cases."""

from pathlib import Path

import pytest

import validation

ROOT = Path(validation.__file__).parent
FILES = sorted(path for room in ("studies", "cases") for path in (ROOT / room).rglob("*.py"))
BY_HAND = ("ddof=1", "errorbar(", "polyfit", "set_xlabel", "set_ylabel")

MOST_LINES = 300
#: Studies that are longer, and how long they may be. Numbers here only fall, and names only go.
LONGER = {
    "_scene.py": 316,
    "accuracy_cost.py": 307,
    "hurst.py": 334,
    "reference.py": 383,
    "refinement.py": 408,
}


@pytest.mark.parametrize("path", FILES, ids=[str(path.relative_to(ROOT)) for path in FILES])
def test_no_study_or_case_reduces_or_labels_by_hand(path):
    text = path.read_text(encoding="utf-8")
    assert [word for word in BY_HAND if word in text] == []


def test_a_study_is_at_most_300_lines():
    lines = {path.name: len(path.read_text(encoding="utf-8").splitlines()) for path in FILES}
    studies = {path.name for path in FILES if path.is_relative_to(ROOT / "studies")}
    longer = {name: lines[name] for name in studies if lines[name] > MOST_LINES}
    assert longer.keys() == LONGER.keys()
    assert all(longer[name] <= most for name, most in LONGER.items()), longer
