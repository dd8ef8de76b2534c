"""Studies read back through the command: what cannot be computed again is listed.

``python tests/validation/test_audit_studies.py`` writes gold/judged.json again, where a change is meant.
"""

import json
import re
import tempfile
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from gold import write_lines
from gold.asked import STUDIES
from gold.make import leave_study, new_numbers

from validation.audit import Ledger, audit
from validation.audit.dataset import Result
from validation.audit.from_solves import second_order_step
from validation.audit.values import judge_dataset
from validation.execution.bench import Bench
from validation.files import read_record, write_record


@pytest.fixture
def folder(tmp_path, left):
    """A small study of its own surfaces, without a report."""
    return left("area", tmp_path / "area", report=False)


def test_a_study_agrees_and_without_its_store_its_solves_are_listed(folder):
    whole = audit(folder)
    assert whole.wrong == ()
    path = folder / "result.json"
    write_record(path, {**read_record(path), "store": "nowhere"})
    ledger = audit(folder)
    assert ledger.wrong == ()
    assert len(ledger.entries) < len(whole.entries)
    assert any("names no store that is there" in line for line in ledger.unread)
    assert "data.nc: area_each" in ledger.unread


#: What solves of a study say that they were asked, which the study has as a position.
_ASKED = {"depth": {"depth", "growth", "poisson"}, "area": {"reduced_pressure"}, "scaling": {"points"}}


#: How many numbers of each study are judged, and which are not.
JUDGED = Path(__file__).parent / "gold" / "judged.json"


def judged(folder):
    """Judge the numbers of a study by its solves; return what was judged, and how it stands in the file."""
    result, ledger = Result(folder), Ledger()
    judge_dataset(result, ledger)
    return result, ledger, {"judged": len(ledger.entries), "unread": sorted(ledger.unread)}


@pytest.mark.parametrize("name", STUDIES)
def test_the_numbers_of_each_study_agree_with_its_solves(name, tmp_path, left, numbers):
    result, ledger, found = judged(left(name, tmp_path, report=False))
    assert found == json.loads(JUDGED.read_text(encoding="utf-8"))[name]
    assert [str(entry) for entry in ledger.wrong] == []
    assert _ASKED.get(name, set()) <= {entry.name.partition(" ")[0] for entry in ledger.entries}
    solved = [json.loads(solve.attrs["recipe"]) for solve in result._read.values()]
    used = {recipe["method"] for recipe in solved if "method" in recipe}
    assert used <= {*numbers(name).attrs.get("methods", "theory bem").split()}
    # By what a variable is called it is known for one that names solves.
    for key, variable in result.data.items():
        if variable.values.dtype.kind in "OU" and not key.startswith("solve"):
            assert not re.search(r"-[0-9a-f]{16}\b", " ".join(map(str, variable.values.flat))), key
    if name == "area on a scene":
        assert "data.nc: area_each" not in ledger.unread


def test_what_shows_a_result_and_was_changed_ends_in_a_line(folder):
    (folder / "summary.json").write_text("[]")
    with pytest.raises(ValueError, match=r"summary\.json is not what was written \(SHA-256\)"):
        audit(folder)


def test_a_picture_may_go_but_not_be_changed_and_no_table_may_come_or_go(left, tmp_path):
    folder = left("area", tmp_path / "area")
    picture = next((folder / "figures").glob("*.svg"))
    text = picture.read_text()
    picture.write_text(text.replace("<svg", "<svg ", 1))
    with pytest.raises(ValueError, match=rf"{picture.name} is not what was written"):
        audit(folder)
    picture.unlink()
    assert audit(folder).wrong == ()
    (folder / "table.csv").rename(folder / "mine.csv")
    with pytest.raises(ValueError, match=r"mine\.csv was not written with it"):
        audit(folder)
    (folder / "mine.csv").unlink()
    with pytest.raises(FileNotFoundError, match=r"table\.csv"):
        audit(folder)


def test_a_step_of_second_order_is_that_of_the_two_finest_grids():
    points = np.array([3.0, 4.0, 10.0])
    gap = 0.7 + np.multiply.outer([1.0, -2.0], np.array([np.nan, 1.0, 1.0]) / points**2)
    values = np.stack([gap, gap + 0.1 / points**2], axis=-1).transpose(1, 2, 0)
    solve = xr.Dataset({"gap": (("grid", "shift", "load"), values), "points_per_wave": ("grid", points)})
    fine, step = second_order_step(solve, xr.Variable("load", [0.0, 0.0], {"of": "gap"}))
    np.testing.assert_allclose(fine, values[-1].mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(fine + step, 0.7, rtol=1e-12)


if __name__ == "__main__":
    stored = {}
    with tempfile.TemporaryDirectory() as place:
        bench = Bench.at(Path(place) / "solves")
        for name in STUDIES:
            folder = Path(place) / name
            folder.mkdir()
            numbers = new_numbers(name, bench, folder)
            stored[name] = judged(leave_study(name, numbers, folder, bench=bench, report=False))[2]
    write_lines(JUDGED, dict(sorted(stored.items())))
