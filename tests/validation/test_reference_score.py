"""Theories and numbers on the cells of the reference table: distances, counts and refusals are right."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from commanding import output_of

from persson import elastic
from persson.spectrum import SelfAffine
from validation import reference, study
from validation.errors import UsageError
from validation.reference import table
from validation.report.estimates import total_error
from validation.report.marks import draw
from validation.studies import find_study
from validation.theories import Rough, find_theory

CELLS = table().sel(amplitudes="exact")


def numbers(path, factor=1.0, *, error=""):
    rows = ["hurst,bandwidth,reduced_pressure,area,area_error"]
    for h, b, p in ((0.8, 8.0, 0.05), (0.3, 32.0, 0.2), (1.0, 4.0, 0.01)):
        area = factor * float(CELLS.area.sel(hurst=h, bandwidth=b, reduced_pressure=p))
        rows.append(f"{h},{b},{p},{area!r},{error}")
    path.write_text("\n".join(rows))
    return path


def test_persson_is_his_closed_form_in_every_cell():
    data = study("reference-score", theory=("persson",))
    exact = xr.apply_ufunc(lambda p: elastic.persson_kappa(p) * p, CELLS.reduced_pressure)
    assert float(abs(data.area_scored / exact - 1).max()) < 1e-9
    z_score = 1.96 * (exact - CELLS.area) / total_error(CELLS, "area")
    for name, expected in (("theory_excess", exact / CELLS.area - 1), ("z_score", z_score)):
        found = data[name].isel(theory=0).transpose(*CELLS.area.dims)
        np.testing.assert_allclose(found, expected.transpose(*CELLS.area.dims), rtol=1e-9)


def test_theories_are_told_the_roll_off_and_scored_on_its_cells(tmp_path):
    path = Path(reference.__file__).with_name("plateau.csv")
    data = study("reference-score", theory=("greenwood-williamson",), csv=path, rolloff="plateau")
    assert "120 of 120 cells of plateau.csv" in " ".join(find_study("reference-score").findings(data))
    bent = {"rolloff": "plateau", "q_min": 1.0}
    spectrum = SelfAffine.from_rms_gradient(0.1, hurst=0.8, q_long=4.0, q_short=32.0, **bent)
    rough = Rough(contact_modulus=1.0, moments=spectrum.moments(), spectrum=spectrum, waves=None)
    area = find_theory("greenwood-williamson").area(np.array([0.005]), rough)
    found = data.area_scored.sel(hurst=0.8, bandwidth=8.0, reduced_pressure=0.05)[0]
    assert float(found) == pytest.approx(float(area[0]), rel=1e-6)


def test_panels_of_a_distance_share_one_scale_and_one_bar_of_colours():
    data = study("reference-score", theory=("persson",))
    drawing = draw(find_study("reference-score").views(data).figures[0], data)
    most = float(abs(data.theory_excess).max())
    assert {line.artist.get_clim() for line in drawing.drawn} == {(-most, most)}
    assert len(drawing.figure.axes) == data.sizes["hurst"] + 1


def test_numbers_of_a_file_are_found_as_far_as_they_were_planted(tmp_path):
    path = numbers(tmp_path / "mine.csv", 1.3)
    data = study("reference-score", theory=(), csv=path)
    assert data.theory_excess.notnull().sum() == 3
    assert float(data.theory_excess.max()) == pytest.approx(0.3, rel=1e-12)
    assert float(data.theory_excess.min()) == pytest.approx(0.3, rel=1e-12)
    worst, within = find_study("reference-score").findings(data)
    assert "mine.csv lies above it, by (+30.00" in worst
    assert "0 of 3 cells of mine.csv" in within
    same = study("reference-score", theory=(), csv=numbers(tmp_path / "same.csv"))
    assert "3 of 3 cells of same.csv" in find_study("reference-score").findings(same)[1]
    shipped = study("reference-score", theory=(), csv=Path(reference.__file__).with_name("table.csv"))
    assert "200 of 200 cells of table.csv" in find_study("reference-score").findings(shipped)[1]
    wide = study("reference-score", theory=(), csv=numbers(tmp_path / "wide.csv", 1.3, error="1.0"))
    assert float(abs(wide.z_score).max()) < 1.96 * 0.3


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hurst,bandwidth,area\n0.8,8,0.1", "no column reduced_pressure; it has hurst, bandwidth, area"),
        ("hurst,bandwidth,reduced_pressure,area\n0.8,7,0.05,0.1", "line 2: no cell of the table, which has"),
        ("hurst,bandwidth,reduced_pressure,area\n0.8,8,0.05,1.1", "line 2: area = 1.1: must lie in"),
        ("hurst,bandwidth,reduced_pressure,area\n0.8,8,0.05,x", "line 2: holds what is no number"),
        ("hurst,bandwidth,reduced_pressure,area\n0.8,8,0.05,nan", "line 2: area = nan: must lie in"),
        ("", "it has none"),
    ],
)
def test_a_file_that_is_no_table_of_areas_is_refused(tmp_path, text, words):
    (tmp_path / "mine.csv").write_text(text)
    with pytest.raises(UsageError, match=words):
        study("reference-score", theory=(), csv=tmp_path / "mine.csv")


def test_a_theory_that_says_nothing_and_a_file_that_is_not_there_are_refused(tmp_path, monkeypatch):
    (tmp_path / "silent_theory.py").write_text("def area(p):\n    return p * float('nan')\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(UsageError, match=r"silent_theory:area says nothing on any cell"):
        study("reference-score", theory=("silent_theory:area",))
    with pytest.raises(UsageError, match=r"no\.csv: cannot be read: No such file"):
        study("reference-score", theory=(), csv=tmp_path / "no.csv")


def test_the_command_scores_a_theory_and_leaves_a_page(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = output_of("reference --theory persson --csv", numbers(tmp_path / "m.csv"))
    assert "3 of 3 cells of m.csv" in said
    assert (tmp_path / "results" / "reference-score" / "report.html").exists()
