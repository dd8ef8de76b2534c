"""The pages of the documentation name what there is, and lead where they say."""

import importlib.util
import itertools
import re
import tomllib
from pathlib import Path

import pytest

import fem_contact
import persson
import validation
from fem_contact import face

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = sorted([*ROOT.glob("*.md"), *DOCS.rglob("*.md")])


def _made_by(name):
    spec = importlib.util.spec_from_file_location(f"{name}_pages", DOCS / "assets" / f"{name}.py")
    pages = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pages)
    return pages


@pytest.mark.parametrize("package", [persson, fem_contact])
def test_the_reference_has_every_public_name(package):
    modules = _made_by("reference").modules(package.__name__)
    assert set(package.__all__) <= {*face.__all__, *modules, *itertools.chain(*modules.values())}


def test_the_page_of_the_notebook_has_every_public_name():
    names = set(re.findall(r"\w+", (DOCS / "notebook.md").read_text(encoding="utf-8")))
    assert {*validation.__all__, *face.__all__} - {"main"} <= names


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_between_files_lead_somewhere(page):
    for target, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)]*))?\)", prose(page)):
        if not target.startswith(("http://", "https://")):
            linked = page.parent / target if target else page
            assert linked.exists(), target
            assert not anchor or anchor in anchors(linked), f"{target}#{anchor}"


def prose(page):
    """A page as the site has it: what it includes, without code."""

    def included(name):
        return (ROOT / name[1]).read_text(encoding="utf-8")

    text = re.sub(r'--8<-- "(.*)"', included, page.read_text(encoding="utf-8"))
    return re.sub(r"```.*?```", "", text, flags=re.DOTALL)


def anchors(page):
    return {
        re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", title).strip().lower())
        for title in re.findall(r"^#+ (.*)$", prose(page), flags=re.MULTILINE)
    }


def test_every_page_is_in_the_navigation_of_the_site():
    said = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:")[2]
    pages = [path.relative_to(DOCS) for suffix in ("md", "ipynb") for path in DOCS.rglob(f"*.{suffix}")]
    own = {path.as_posix() for path in pages if "results" not in path.parts}
    assert own == set(re.findall(r"[\w/]+\.(?:md|ipynb)", said))


def test_the_citation_is_of_this_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {project['version']}\n" in citation
    assert f"\nlicense: {project['license']}\n" in citation


def test_the_workflow_calls_what_everybody_calls():
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    versions = ".ci/versions ${{ matrix.versions }} ${{ matrix.python }}"
    assert re.findall(r"run: (.*)", workflow) == [".ci/run", versions]


def test_the_readme_fits_on_a_screen_and_a_half():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(readme.splitlines()) < 110


def test_the_glossary_is_that_of_the_registry():
    assert (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8") == _made_by("generated").glossary()


def test_the_page_of_scene_keys_is_that_of_the_tables():
    assert (ROOT / "docs" / "scene.md").read_text(encoding="utf-8") == _made_by("generated").scene_page()
