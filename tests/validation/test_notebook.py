"""Notebooks, recipes and the README run from top to bottom, and say what they promise."""

import json
import re
import shlex
from pathlib import Path

import pytest
from commanding import output_of

import fem_contact as fc
from fem_contact import HalfSpace, HeightField, Solid, bem
from validation import self_affine
from validation.report.values import value_of
from validation.scenes.topography.writing import write_topography

DOCS = Path(__file__).parents[2] / "docs"


def _run(name):
    path = DOCS / f"{name}.ipynb"
    space: dict[str, object] = {}
    cells = json.loads(path.read_text())["cells"]
    sources = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    for source in sources:
        exec(compile(source, str(path), "exec"), space)
    return space, sources


def test_the_notebook_of_studies_runs_and_its_findings_are_computed():
    space, _ = _run("studies_in_python")
    told = " ".join(fc.study.findings(space["data"]))
    assert f"In the limit kappa is {value_of(space['data'], 'kappa')} at p* = 0.05" in told
    assert space["kappa"].sizes["surface"] == 4
    assert len(fc.study.budget(space["kappa"]).rows) == len(space["kappa"]["kappa"].to_dataframe())


def test_each_of_ten_things_takes_four_lines_at_most_and_gives_its_numbers(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    space, sources = _run("ten_things")
    assert max(len(source.splitlines()) for source in sources[1:]) <= 4
    sweep, hursts, limit = space["sweep"], space["hursts"], space["contact"].limit()
    assert list(sweep.area) == sorted(sweep.area)
    assert (sweep.area > sweep.persson).all()
    assert hursts.hurst.values.tolist() == [0.3, 0.8]
    # The same grids of the same surface: a number of one cell is that of the other.
    assert hursts.kappa_limit.sel(hurst=0.8).item() == pytest.approx(limit.value / 0.05, rel=1e-12)
    # 0.12389 is the limit that the ladder to 512 x 512 gives (README).
    assert abs(limit.value - 0.12389) < 2 * limit.error < 0.01
    assert hursts.kappa_limit_error.sel(hurst=0.8).item() == pytest.approx(limit.error / 0.05, rel=1e-12)
    assert space["patches"].count == 10


def _afm(folder):
    rough = {"hurst": 0.8, "lambda_long": "500 nm", "lambda_short": "125 nm", "rms_gradient": 0.1, "seed": 2}
    heights = self_affine(length="1 um", **rough).heights(24).values
    write_topography(folder / "afm.nc", field := HeightField(heights=heights, lengths=(1e-6, 1e-6)))
    return field


def _blocks(path, language):
    return re.findall(rf"```{language}\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)


def test_the_lines_of_python_in_the_readme_print_what_it_shows(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    readme = DOCS.parent / "README.md"
    (source,) = _blocks(readme, "python")
    exec(compile(source, str(readme), "exec"), {})
    assert capsys.readouterr().out == _blocks(readme, "text")[-1]
    assert {path.name for path in tmp_path.iterdir()} == {"stress.png", "fields.nc"}


@pytest.mark.nightly
def test_the_recipes_run_in_their_order(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    _afm(tmp_path)
    space: dict[str, object] = {}
    for source in _blocks(DOCS / "how_to.md", "python"):
        if 'study("hurst"' in source:  # minutes; the study has tests of its own
            continue
        exec(compile(source, "how_to.md", "exec"), space)
    assert list(space["sweep"].limit) == sorted(space["sweep"].limit)
    # Each method's own edge constant brings the areas of the two nearer.
    check = space["check"]
    assert abs(check.area_perimeter_difference) < abs(check.area_pixel_difference)
    assert (tmp_path / "block.vtu").exists()
    assert float(capsys.readouterr().out.split()[0]) == pytest.approx(0.1125, abs=5e-5)


#: What needs another machine or another package, hours, or results that a reader makes first.
_ELSEWHERE = re.compile(
    r"mpi|dask|SLURM|--scheduler|--accuracy|pip install|compare |challenge score|^(export|python3) "
    r"|--method tamaas|scan\.npy|my_module:area|import MPI|def solve\(.*\.\.\."
)


@pytest.mark.nightly
@pytest.mark.parametrize("page", sorted(DOCS.glob("*.md")), ids=lambda page: page.stem)
def test_the_examples_of_a_page_run(page, tmp_path, monkeypatch):
    """Python as it stands; commands too, but runs and studies by their plans."""
    monkeypatch.chdir(tmp_path)
    text = page.read_text(encoding="utf-8")
    half_space, surface = HalfSpace(solid=Solid(young=1e9, poisson=0.3)), _afm(tmp_path)
    contact = bem.solve(surface, half_space, mean_pressure=5e6)
    space = {"surface": surface, "half_space": half_space, "contact": contact}
    if "scenes copy" not in text:
        output_of("scenes copy quickstart mine.toml")
    for language, source in re.findall(r"```(python|sh|toml)\n(.*?)```", text, re.DOTALL):
        if language == "toml":
            (tmp_path / "scene.toml").write_text(source, encoding="utf-8")
        elif source.startswith("# my_module.py"):
            (tmp_path / "my_module.py").write_text(source, encoding="utf-8")
        elif language == "python" and not _ELSEWHERE.search(source) and 'study("hurst"' not in source:
            exec(compile(source, str(page), "exec"), space)
        for line in source.splitlines() if language == "sh" else ():
            verb, *words = shlex.split(line, comments=True) or [""]
            if verb == "fem-contact" and not _ELSEWHERE.search(line):
                plan = ["--dry-run"] if words[0] in ("run", "study") and "--dry-run" not in words else []
                output_of(*words, *plan)
