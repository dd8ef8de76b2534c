"""The notebooks of the documentation run from top to bottom, and say what they promise."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


def _run(name: str) -> tuple[dict[str, object], list[str]]:
    path = DOCS / f"{name}.ipynb"
    space: dict[str, object] = {}
    sources = [
        "".join(c["source"]) for c in json.loads(path.read_text())["cells"] if c["cell_type"] == "code"
    ]
    for source in sources:
        exec(compile(source, str(path), "exec"), space)
    return space, sources


def test_the_notebook_of_studies_runs_and_its_sentences_are_computed(capsys):
    space, _ = _run("studies")
    printed = capsys.readouterr().out
    assert "kappa in the limit of vanishing spacing" in printed
    assert "Spectra of alpha 3" in printed
    assert space["kappa"].sizes["surface"] == 4


def test_each_of_ten_things_takes_three_lines_at_most_and_gives_its_numbers(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    space, sources = _run("ten_things")
    assert max(len(source.splitlines()) for source in sources[1:]) <= 3
    sweep, hursts, limit = space["sweep"], space["hursts"], space["limit"]
    assert list(sweep.area) == sorted(sweep.area)
    assert (sweep.area > sweep.persson).all()
    assert hursts.hurst.values.tolist() == [0.3, 0.8]
    # The same grids of the same surface: a number of one cell is that of the other.
    assert hursts.kappa_limit.sel(hurst=0.8).item() == pytest.approx(limit.value / 0.05, rel=1e-12)
    # 0.12389 is the limit that the ladder to 512 x 512 gives (README); four standard errors.
    assert abs(limit.value - 0.12389) < 4 * limit.uncertainty < 0.01
    assert (tmp_path / "block.vtu").stat().st_size > 10_000
    assert space["own"].realised.pressure == 5e6
    assert "10 patches" in capsys.readouterr().out
