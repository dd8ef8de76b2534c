"""What an installed copy promises: types, metadata, data files, and imports that cost nothing."""

import importlib.metadata
import importlib.resources
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("contact_checks", "persson", "fem_contact", "validation")

#: Libraries that a computation, a picture or the command line needs, but never the bare import of a package.
_HEAVY = """
numba llvmlite skfem pyamg meshio pyvista vtkmodules matplotlib xarray h5py h5netcdf pandas dask pydantic pint
typer rich jinja2 psutil
"""
HEAVY = {*_HEAVY.split()}


@pytest.fixture(scope="module")
def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def distribution():
    return importlib.metadata.distribution("fem-contact")


def run_elsewhere(code, directory):
    """Standard output of a fresh interpreter that sees these packages and stands in another directory."""
    command = [sys.executable, "-W", "error", "-c", f"import sys; sys.path.insert(0, {str(ROOT)!r}); {code}"]
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def imported_libraries(modules, directory, then="0"):
    """Top-level names in sys.modules after the imports, and what is done then."""
    code = f"import json, {', '.join(modules)}; {then}; print(json.dumps(sorted(sys.modules)))"
    return {name.partition(".")[0] for name in json.loads(run_elsewhere(code, directory))}


def test_every_package_says_that_it_is_typed():
    for package in PACKAGES:
        assert importlib.resources.files(package).joinpath("py.typed").is_file()


def test_the_installed_metadata_are_those_of_the_project(project, distribution):
    assert distribution.metadata["Name"] == project["name"] == "fem-contact"
    assert distribution.version == project["version"]
    assert distribution.metadata["Requires-Python"] == project["requires-python"]


def test_the_version_has_its_entry_in_the_changelog(project):
    headings = [
        line for line in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines() if "## [" in line
    ]
    assert any(f"[{project['version']}]" in line for line in headings)


def test_every_release_in_the_changelog_says_which_numbers_changed():
    releases = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").split("\n## [")[1:]
    assert releases
    for release in releases:
        assert "### Numbers changed" in release, release.splitlines()[0]


@pytest.mark.parametrize("package", PACKAGES)
def test_importing_and_listing_a_package_imports_no_heavy_library(package, tmp_path):
    listed = imported_libraries([package], tmp_path, then=f"dir({package})")
    assert not listed & (HEAVY | ({"numpy", "scipy"} if package in ("fem_contact", "persson") else set()))


def test_surfaces_solids_results_and_closed_forms_need_no_heavy_library(tmp_path):
    solvers = ["fem_contact.surface", "fem_contact.solid", "fem_contact.response", "fem_contact.contact"]
    modules = [*solvers, "persson.spectrum", "persson.elastic"]
    assert not imported_libraries(modules, tmp_path) & HEAVY


def test_the_packages_need_nobody_of_the_test_environment(tmp_path):
    assert not imported_libraries(PACKAGES, tmp_path) & {"pytest", "hypothesis", "mypy", "setuptools"}


def test_theory_and_solvers_are_imported_without_each_other(tmp_path):
    assert not imported_libraries(["persson"], tmp_path) & {"fem_contact", "validation"}
    assert not imported_libraries(["fem_contact.contact"], tmp_path) & {"persson", "validation"}


def test_the_console_command_is_declared(distribution):
    scripts = [one for one in distribution.entry_points if one.group == "console_scripts"]
    assert [(one.name, one.value) for one in scripts] == [("fem-contact", "fem_contact.face:main")]


def test_the_command_line_starts_without_solvers_and_pictures(tmp_path):
    libraries = imported_libraries(["validation.cli"], tmp_path)
    assert not libraries & {"numba", "skfem", "pyamg", "meshio", "pyvista", "matplotlib"}


def test_scenes_are_found_from_any_directory(tmp_path):
    scene = "importlib.resources.files('validation.scenes').joinpath('library', 'quickstart.toml')"
    code = f"import importlib.resources; print({scene}.read_text(encoding='utf-8'))"
    assert tomllib.loads(run_elsewhere(code, tmp_path))


def test_hooks_and_ci_run_the_same_linters():
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    entries = set(re.findall(r"^\s*entry: *(.*?)\s*$", hooks, re.M))
    lines = set((ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines())
    assert entries - {"python -m pytest -q"} == {"ruff check", "ruff format --check", "mypy", "lint-imports"}
    assert entries - lines == {"python -m pytest -q"}


def test_the_readme_names_the_command_that_ci_runs():
    _, _, after = (ROOT / "README.md").read_text(encoding="utf-8").partition("<!-- test-command -->")
    command = after.partition("```")[2].partition("\n")[2].partition("```")[0]
    assert "pytest" in command
    assert ".venv" in command


def test_the_map_names_every_room():
    words = set(re.findall(r"\w+", (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")))
    inside = list((ROOT / "validation").iterdir())
    rooms = {path.stem for path in inside if path.suffix == ".py" or (path / "__init__.py").exists()}
    rooms = {room for room in rooms if not room.startswith("_")}
    assert len(rooms) > 8
    assert rooms - words == set()
