"""The pages of the documentation name what there is, and lead where they say."""

import re
import tomllib
from pathlib import Path

import pytest

import fem_contact
import persson
import validation
from validation.report.quantities import glossary
from validation.scenes.keys import scene_page

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
CODE = re.compile(r"```python\n(.*?)```", re.DOTALL)
PAGES = sorted([*ROOT.glob("*.md"), *DOCS.rglob("*.md")])


@pytest.mark.parametrize(
    ("page", "package"),
    [("persson", persson), ("fem_contact", fem_contact), ("notebook", validation)],
)
def test_the_reference_has_every_public_name(page, package):
    text = (DOCS / "reference" / f"{page}.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"[\w.]+", text))
    last = {name.rpartition(".")[2] for name in shown}
    assert set(package.__all__) <= last


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_between_files_lead_somewhere(page):
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text):
        if not target.startswith(("http://", "https://")):
            assert (page.parent / target).exists(), target


def test_every_page_is_in_the_navigation_of_the_site():
    said = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:")[2]
    pages = [*DOCS.rglob("*.md"), *DOCS.rglob("*.ipynb")]
    assert {path.relative_to(DOCS).as_posix() for path in pages if "results" not in path.parts} == set(
        re.findall(r"[\w/]+\.(?:md|ipynb)", said)
    )


def test_the_citation_is_of_this_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {project['version']}\n" in citation
    assert f"\nlicense: {project['license']}\n" in citation


def test_the_workflow_calls_what_everybody_calls():
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    assert re.findall(r"run: (.*)", workflow) == [
        ".ci/run",
        ".ci/versions ${{ matrix.versions }} ${{ matrix.python }}",
    ]


def test_the_readme_fits_on_a_screen_and_a_half():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(readme.splitlines()) < 110


def test_the_glossary_is_that_of_the_registry():
    assert (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8") == glossary()


def test_the_page_of_scene_keys_is_that_of_the_tables():
    assert (ROOT / "docs" / "scene.md").read_text(encoding="utf-8") == scene_page()


def test_the_study_of_the_architecture_is_the_one_that_is_tested():
    pages = [(ROOT / name).read_text(encoding="utf-8") for name in ("ARCHITECTURE.md", "docs/studies.md")]
    first, second = (next(code for code in CODE.findall(page) if "counts" in code) for page in pages)
    assert first == second
