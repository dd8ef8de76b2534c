"""Solvers written elsewhere: bounded, recomputed, and never trusted."""

import contextlib
import sys
import textwrap
from pathlib import Path

import numpy as np
import psutil
import pytest

sys.path.insert(0, str(Path(__file__).parent))
from solving import still_running

from fem_contact.area import contact_areas
from fem_contact.contact import Status
from fem_contact.errors import NotConverged
from fem_contact.solid import Solid
from validation.effects import Effect, effect_kinds
from validation.effects.base import ContactModel
from validation.effects.hardness import Hardness
from validation.effects.thickness import Thickness
from validation.errors import UsageError
from validation.execution.press import solves_of
from validation.scenes.checks import check_scene
from validation.scenes.problem import realise
from validation.scenes.scene import load_scene
from validation.solvers import find_method, find_solver, methods
from validation.solvers.base import Job, Solver, example_field
from validation.solvers.bem import Bem

METHODS = (Path(__file__).parents[2] / "docs" / "methods.md").read_text(encoding="utf-8")
SCENE = """
[surface]
kind = "self-affine"
length = 1.0
hurst = 0.8
lambda_long = 0.5
lambda_short = 0.25
rms_gradient = 0.1
seed = 17
[solid]
young = 1.0
poisson = 0.0
[load]
reduced_pressure = 0.1
[methods.bem]
grids = [16, 24, 32]
"""


@pytest.fixture
def own_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The solver of docs/methods.md, in the folder the command is started in."""
    code = METHODS.split("<!-- own-solver -->")[1].split("```python\n")[1].split("```")[0]
    (tmp_path / "my_module.py").write_text(code, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def job(
    load: float = 0.01, *, points: int = 32, model: ContactModel | None = None, **settings: object
) -> Job:
    model = model or ContactModel(solid=Solid(young=1.0, poisson=0.0))
    return Job(
        field=example_field(points), load={"mean_pressure": load}, model=model, settings=settings, threads=1
    )


def pressed(solver: str, **settings: float):
    return find_solver("own").solve(job(solver=solver, **settings)).contact


def written(name: str, body: str) -> str:
    code = "import numpy as np\ndef solve(heights, lengths, *, contact_modulus, mean_pressure):\n"
    Path(f"{name}.py").write_text(code + textwrap.indent(textwrap.dedent(body), "    "), encoding="utf-8")
    return f"{name}:solve"


def test_the_solver_of_the_docs_agrees_with_boundary_elements(own_module: Path) -> None:
    reference = find_solver("bem").solve(job(tolerance=1e-10)).contact
    found = pressed("my_module:solve", tolerance=1e-6).checked()
    # An energy error of the tolerance leaves its square root in the pressure.
    assert np.linalg.norm(found.pressure - reference.pressure) < 1e-3 * np.linalg.norm(reference.pressure)
    assert np.array_equal(found.in_contact, reference.in_contact)


def test_another_text_of_the_module_is_another_recipe(own_module: Path) -> None:
    scene = SCENE + '[methods.own]\nsolver = "my_module:solve"\ngrids = [16]\n'
    Path("mine.toml").write_text(scene, encoding="utf-8")

    def key() -> str:
        loaded = load_scene("mine.toml")
        return next(solve.key for solve in solves_of(loaded) if solve.method == "own")

    before = key()
    assert key() == before
    with Path("my_module.py").open("a", encoding="utf-8") as file:
        file.write("\n# changed\n")
    assert key() != before


def test_a_module_that_is_not_there_is_refused_before_anything_is_solved(own_module: Path) -> None:
    scene = SCENE + '[methods.own]\nsolver = "no_such_module_here:solve"\ngrids = [16]\n'
    Path("mine.toml").write_text(scene, encoding="utf-8")
    loaded = load_scene("mine.toml")
    with pytest.raises(UsageError, match=r"methods\.own\.solver.*no module 'no_such_module_here'"):
        check_scene(loaded, realise(loaded))


def test_a_claim_of_convergence_is_recomputed_from_the_pressure(own_module: Path) -> None:
    solver = written(
        "uniform", "return {'pressure': np.full(heights.shape, mean_pressure), 'converged': True}"
    )
    found = pressed(solver)
    assert found.status is Status.NOT_CONFIRMED
    assert found.residuals.complementarity > 0.1
    with pytest.raises(NotConverged, match="above the tolerance"):
        found.checked()


@pytest.mark.parametrize(
    ("name", "body", "says"),
    [
        ("raises", "raise ValueError('no such thing')", "raised ValueError: no such thing"),
        ("crashes", "import os; os.abort()", "crashed its process"),
        ("sleeps", "import time; time.sleep(60)", "took more than 1 s"),
        ("small", "return np.zeros((2, 2))", r"shape \(2, 2\): must have that of the heights"),
        ("nan", "return np.full(heights.shape, np.nan)", None),
        ("load", "return np.full(heights.shape, 2 * mean_pressure)", None),
    ],
)
def test_what_goes_wrong_in_a_foreign_solver_is_said(
    own_module: Path, name: str, body: str, says: str | None
) -> None:
    solver = written(name, body)
    with pytest.raises(NotConverged, match=says):
        pressed(solver, seconds=1.0 if name == "sleeps" else 60.0).checked()


def test_what_a_foreign_solver_starts_ends_with_it(own_module: Path) -> None:
    body = f"""
    import subprocess
    open({str(own_module / "started")!r}, "w").write(str(subprocess.Popen(["sleep", "600"]).pid))
    import time; time.sleep(60)
    """
    with pytest.raises(NotConverged, match=r"took more than 5 s"):
        pressed(written("starts", body), seconds=5.0)
    process = int((own_module / "started").read_text())
    with contextlib.suppress(psutil.NoSuchProcess):
        assert not still_running([psutil.Process(process)], seconds=2)


def test_a_point_with_a_pressure_of_rounding_size_is_not_in_contact(own_module: Path) -> None:
    solver = written(
        "haze",
        """
        import my_module
        p = my_module.solve(heights, lengths, contact_modulus=contact_modulus, mean_pressure=mean_pressure)
        return np.maximum(p, 1e-15 * mean_pressure)
        """,
    )
    found = pressed(solver).checked()
    assert np.all(found.pressure > 0)
    assert np.array_equal(found.in_contact, pressed("my_module:solve").in_contact)


def test_the_edge_of_a_foreign_contact_is_located_as_that_of_boundary_elements(own_module: Path) -> None:
    reference = find_solver("bem").solve(job(tolerance=1e-10))
    found = contact_areas(pressed("my_module:solve").checked(), subcell=True)
    assert found.subcell == pytest.approx(contact_areas(reference.contact, subcell=True).subcell, rel=1e-4)


def test_foreign_solvers_stand_after_the_others() -> None:
    solvers = [method for method in methods().values() if isinstance(method, Solver)]
    flags = [solver.foreign for solver in solvers]
    assert flags == sorted(flags)


@pytest.mark.parametrize(
    ("name", "handled"),
    [
        ("own", set()),
        ("tamaas", {"hardness"}),
        ("contact_mechanics", {"hardness", "thickness"}),
        ("calculix", {"thickness"}),
    ],
)
def test_foreign_solvers_are_given_what_they_can_be_given(name: str, handled: set[str]) -> None:
    assert {
        kind.kind_name() for kind in effect_kinds().values() if find_method(name).handles(kind)
    } == handled


def test_a_layer_that_slides_on_its_base_is_refused_by_name(own_module: Path) -> None:
    tables = "[methods.contact_mechanics]\ngrids = [16]\n"
    effect = '[[effects]]\nkind = "thickness"\nthickness = 0.2\nbase = "frictionless"\n'
    Path("layer.toml").write_text(SCENE.split("[methods")[0] + effect + tables, encoding="utf-8")
    scene = load_scene("layer.toml")
    options = scene.methods.options("contact_mechanics")
    with pytest.raises(UsageError, match=r"\[\[effects\]\] 1 kind = 'thickness'.*'contact_mechanics'"):
        find_method("contact_mechanics").check(options, realise(scene), scene.effects)


def test_a_method_that_takes_no_job_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    class Old(Bem):
        def solve(self, field, *, mean_pressure, model, settings, threads=None): ...

    monkeypatch.setattr("validation.solvers.found_in", lambda *_, **__: (Old,))
    with pytest.raises(UsageError, match=r"method 'bem' of .*: its `solve` takes one `job` now"):
        methods.__wrapped__()


@pytest.mark.parametrize("name", ["tamaas", "contact_mechanics"])
def test_a_peer_that_is_missing_says_what_to_install(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda package: None)
    assert "pip install 'fem-contact[peers]'" in str(find_method(name).available())


@pytest.mark.parametrize("name", ["tamaas", "contact_mechanics"])
@pytest.mark.parametrize("load", [1e-4, 0.01, 0.1])
def test_a_peer_agrees_with_boundary_elements(name: str, load: float) -> None:
    peer = find_solver(name)
    if peer.available() is not None:
        pytest.skip(str(peer.available()))
    solid = Solid(young=2e9, poisson=0.3)
    asked = job(load * solid.contact_modulus, points=64, model=ContactModel(solid=solid), tolerance=1e-9)
    found, ours = (solver.solve(asked).contact.checked() for solver in (peer, find_solver("bem")))
    assert np.linalg.norm(found.pressure - ours.pressure) < 1e-4 * np.linalg.norm(ours.pressure)
    assert np.array_equal(found.in_contact, ours.in_contact)


@pytest.mark.parametrize(
    ("name", "effect"),
    [
        ("tamaas", Hardness(hardness=0.06)),
        ("contact_mechanics", Hardness(hardness=0.06)),
        ("contact_mechanics", Thickness(thickness=0.1)),
    ],
)
def test_a_peer_with_an_effect_agrees_with_boundary_elements(name: str, effect: Effect) -> None:
    peer = find_solver(name)
    if peer.available() is not None:
        pytest.skip(str(peer.available()))
    model = ContactModel.filled(Solid(young=1.0, poisson=0.3), [effect])
    asked = job(0.02, points=64, model=model, tolerance=1e-9)
    found, ours = (solver.solve(asked) for solver in (peer, find_solver("bem")))
    theirs = found.contact.checked()
    # An energy error of the tolerance leaves its square root in the pressure.
    apart = np.linalg.norm(theirs.pressure - ours.contact.pressure)
    assert apart < 1e-4 * np.linalg.norm(ours.contact.pressure)
    assert np.array_equal(theirs.at_bound, ours.contact.at_bound)
