"""Whatever a scene file holds, it is a scene or a refusal that names the mistake: never another error."""

import contextlib
import re
import tomllib

import numpy as np
import pytest
from commanding import invoke, output_of
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from small_scene import changed, square_scene

from validation.errors import SceneError, UsageError
from validation.scenes.checks import check_scene
from validation.scenes.mistakes import problems
from validation.scenes.problem import realise
from validation.scenes.scene import Scene, load_scene, scene_text

BASE = 'name = "fuzz"' + square_scene(
    """[methods.theory]
[ensemble]
realisations = 2
grids = [32, 48]
[[effects]]
kind = "coating"
young = "2 GPa"
thickness = "1 um"
""",
    length='["10 um", 1e-5]',
    grids="[32, [32, 48]]",
)
TREE = tomllib.loads(BASE)
ALONE = tomllib.loads(scene_text("pyrex-squeezed")[0])

WORDS = st.sampled_from(
    (
        "0.5 um|10 MPa|-1 m|1e400 m|nan m|1 m m|1 kg*m/s^2|5| m|1 um**2|1 (|1 __import__|self-affine|file|"
        "hardness|adhesion|thickness|graded|cracks|size-dependent-hardness|sharp|50 mJ/m^2|\x00|" + "ä" * 40
    ).split("|")
)
KEYS = st.sampled_from(["kind", "length", "work", "x"])
LEAVES = st.one_of(
    *(st.none(), st.booleans(), st.integers(-(10**30), 10**30), st.floats(), st.text(max_size=12), WORDS)
)
VALUES = st.recursive(
    LEAVES, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner), max_leaves=6
)


def places(tree, path=""):
    """Every key of the scene, and one that is not there."""
    found = [f"{path}unknown"]
    items = tree.items() if isinstance(tree, dict) else enumerate(tree)
    for key, value in items:
        found.append(f"{path}{key}")
        if isinstance(value, (dict, list)):
            found.extend(places(value, f"{path}{key}."))
    return found


PLACES = [
    place
    for place in [*places(TREE), *places(ALONE), "load.pressure", "methods.fem", "run", "surface.path"]
    if not re.search(r"\d\.\d+$", place)
]


def judged(tree):
    """Read a scene as the command line does; None where it is refused in words."""
    try:
        scene = Scene.model_validate(tree)
    except ValidationError as error:
        lines = problems(error)
        assert lines
        assert all(isinstance(line, str) and line for line in lines)
        return None
    try:
        check_scene(scene, realise(scene))
    except UsageError:
        return None
    return scene


def numbers(value):
    """All floating-point numbers of a checked scene."""
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list | tuple) else ()
    return [value] if isinstance(value, float) else [n for part in inner for n in numbers(part)]


@settings(max_examples=300, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.sampled_from([TREE, ALONE]),
    st.lists(st.tuples(st.sampled_from(PLACES), VALUES), min_size=1, max_size=3),
)
@example(TREE, [("surface.kind", ["file"])])
@example(TREE, [("effects.0.kind", {"kind": None})])
@example(TREE, [("surface.length", "1e400 m")])
@example(TREE, [("effects", {"kind": "hardness"})])
@example(TREE, [("effects", ["hardness"])])
@example(TREE, [("surface", None)])
@example(ALONE, [("load.pressure", [0.0, "1 m"])])
@example(ALONE, [("load.pressure", [[]])])
@example(ALONE, [("load.pressure", {"several": 1.0})])
def test_a_changed_scene_is_a_scene_of_finite_numbers_or_a_refusal_in_words(tree, changes):
    for place, value in changes:
        tree = changed(tree, place, value)
    scene = judged(tree)
    assert scene is None or np.isfinite(numbers(scene.model_dump())).all()


@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture])
@given(place=st.integers(0, len(BASE)), cut=st.integers(0, 12), text=st.binary(max_size=8))
@example(0, len(BASE), "[surface\n\u0085".encode())
def test_a_file_of_damaged_text_is_read_or_refused(tmp_path, place, cut, text):
    path = tmp_path / "scene.toml"
    raw = BASE.encode()
    path.write_bytes(raw[:place] + text + raw[place + cut :])
    with contextlib.suppress(SceneError):
        load_scene(str(path))


@settings(max_examples=60)
@given(st.text(max_size=30))
@example("")
@example(".")
@example("/")
@example("\x00.toml")
@example("a" * 5000 + ".toml")
def test_a_name_that_is_no_scene_is_refused(name):
    with pytest.raises(SceneError):
        scene_text(name)


WORDS_OF_THE_COMMAND = (
    "explain study run scenes list show --json --quiet --list --cases none.toml quickstart stability "
    "--workers -1 nonsense --help --dry-run"
)


@settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture])
@given(st.lists(st.sampled_from(WORDS_OF_THE_COMMAND.split(" ")), max_size=4))
def test_the_command_line_ends_with_an_exit_code_and_no_traceback(tmp_path, arguments):
    if "run" in arguments and "quickstart" in arguments:
        arguments = [*arguments, "--dry-run"]
    if "study" in arguments and "stability" in arguments:
        arguments = [*arguments, "--cases", "nonsense"]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        result = invoke("", *arguments)
    expected = (SystemExit, UsageError, SceneError)
    assert result.exception is None or isinstance(result.exception, expected), result.exception


@pytest.mark.parametrize("name", ["stability", "graded"])
def test_a_dry_run_of_a_study_that_needs_no_job_computes_nothing(monkeypatch, tmp_path, name):
    monkeypatch.chdir(tmp_path)
    assert "0 of 0 solves" in output_of(f"study {name} --dry-run")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("text", ["a = " + "[" * 3000, "a = " + "9" * 5000, "a = 1\nb"])
def test_what_the_parser_gives_up_on_is_no_scene(tmp_path, text):
    path = tmp_path / "scene.toml"
    path.write_text(text)
    with pytest.raises(SceneError, match=r"not valid TOML|nested too deeply"):
        load_scene(str(path))
