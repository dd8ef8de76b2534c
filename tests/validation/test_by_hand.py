"""What the kit does is not done by hand: reductions, axes and long files in studies and cases."""

from pathlib import Path

import pytest

import validation

ROOT = Path(validation.__file__).parent
FILES = sorted(path for room in ("studies", "cases") for path in (ROOT / room).rglob("*.py"))
BY_HAND = ("ddof=1", "errorbar(", "polyfit", "set_xlabel", "set_ylabel")

MOST_LINES = 300


@pytest.mark.parametrize("path", FILES, ids=[str(path.relative_to(ROOT)) for path in FILES])
def test_no_study_or_case_reduces_or_labels_by_hand(path):
    text = path.read_text(encoding="utf-8")
    assert [word for word in BY_HAND if word in text] == []


def test_a_study_is_at_most_300_lines():
    lines = {path.name: len(path.read_text(encoding="utf-8").splitlines()) for path in FILES}
    studies = {path.name for path in FILES if path.is_relative_to(ROOT / "studies")}
    longer = {name: lines[name] for name in studies if lines[name] > MOST_LINES}
    assert longer == {}
