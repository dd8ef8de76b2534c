"""Solvers written elsewhere: bounded, recomputed, and never trusted."""

import contextlib
import random
import textwrap
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import psutil
import pytest
from refusing import refused
from small_scene import scene_in, small_scene, square_scene
from solving import still_running

from fem_contact import HeightField, NotConverged, Solid, Status, contact_areas
from validation import sandbox
from validation.audit import audit
from validation.comparison.run import run_scene
from validation.effects import effect_kinds
from validation.effects.base import ContactModel
from validation.effects.hardness import Hardness
from validation.effects.thickness import Thickness
from validation.errors import SolvesFailed, UsageError
from validation.execution.press import solves_of
from validation.scenes.checks import check_scene
from validation.scenes.problem import realise
from validation.scenes.scene import load_scene
from validation.solvers import aspher, find_method, find_solver, methods
from validation.solvers.base import Job, Solver, example_field
from validation.solvers.bem import Bem
from validation.studies import find_study

METHODS = (Path(__file__).parents[2] / "docs" / "methods.md").read_text(encoding="utf-8")
SCENE = small_scene(grids="[16, 24, 32]")


@pytest.fixture
def own_module(tmp_path, monkeypatch):
    """The solver of docs/methods.md, in the folder the command is started in."""
    code = METHODS.split("<!-- own-solver -->")[1].split("```python\n")[1].split("```")[0]
    (tmp_path / "my_module.py").write_text(code, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def job(load=0.01, *, points=32, model=None, **settings):
    model = model or ContactModel(solid=Solid(young=1.0, poisson=0.0))
    return Job(
        field=example_field(points), load={"mean_pressure": load}, model=model, settings=settings, threads=1
    )


def pressed(solver, **settings):
    return find_solver("own").solve(job(solver=solver, **settings)).contact


def written(name, body):
    code = "import numpy as np\ndef solve(heights, lengths, *, contact_modulus, mean_pressure):\n"
    Path(f"{name}.py").write_text(code + textwrap.indent(textwrap.dedent(body), "    "), encoding="utf-8")
    return f"{name}:solve"


def test_the_solver_of_the_docs_agrees_with_boundary_elements(own_module):
    reference = find_solver("bem").solve(job(tolerance=1e-10)).contact
    found = pressed("my_module:solve", tolerance=1e-6).checked()
    # An energy error of the tolerance leaves its square root in the pressure.
    assert np.linalg.norm(found.pressure - reference.pressure) < 1e-3 * np.linalg.norm(reference.pressure)
    assert np.array_equal(found.in_contact, reference.in_contact)


def own_scene(solver):
    scene = f'{SCENE}[methods.own]\nsolver = "{solver}"\ngrids = [16]\n' if solver else SCENE
    Path("mine.toml").write_text(scene, encoding="utf-8")
    return load_scene("mine.toml")


def test_another_text_of_the_module_is_another_recipe(own_module):
    def key():
        solves = solves_of(own_scene("my_module:solve"))
        return next(solve.key for solve in solves if solve.method == "own")

    before = key()
    assert key() == before
    with Path("my_module.py").open("a", encoding="utf-8") as file:
        file.write("\n# changed\n")
    assert key() != before


def test_a_module_that_is_not_there_is_refused_before_anything_is_solved(own_module):
    loaded = own_scene("no_such_module_here:solve")
    with pytest.raises(UsageError, match=r"methods\.own\.solver.*no module 'no_such_module_here'"):
        check_scene(loaded, realise(loaded))


def test_a_claim_of_convergence_is_recomputed_from_the_pressure(own_module):
    claim = "{'pressure': np.full(heights.shape, mean_pressure), 'converged': True}"
    found = pressed(written("uniform", f"return {claim}"))
    assert found.status is Status.NOT_CONFIRMED
    assert found.residuals.complementarity > 0.1
    with pytest.raises(NotConverged, match="above the tolerance"):
        found.checked()


@pytest.mark.skipif(not Path("/proc/self/clear_refs").exists(), reason="the system keeps no such peak")
def test_memory_that_a_solver_gives_back_is_of_its_peak(own_module):
    large = "np.ones(20_000_000)\nreturn np.full(heights.shape, mean_pressure)"
    assert 1.5e8 < pressed(written("large", large)).cost.peak_bytes < 2.6e8
    # Of the next call it is not.
    half = large.replace("20_000_000", "10_000_000")
    assert 0.6e8 < pressed(written("half", half)).cost.peak_bytes < 1.4e8
    with pytest.raises(NotConverged, match="took more than 64 MiB of memory"):
        pressed(written("large", large), memory=2**26)


@pytest.mark.parametrize("where", ["options", "scene"])
def test_a_study_whose_solver_fails_is_that_of_the_others(own_module, bench, where):
    raising = written("raising", "raise ValueError('not on this grid')")

    def studied(name, *methods):
        study = find_study(name)
        if where == "options":
            options = study.parse(["--methods", ",".join(["bem", *methods]), *FEW])
            return study.compute(options, bench=bench)
        scene = own_scene(raising if raising in methods else "")
        return study.compute(study.parse(["--surfaces", "2"], scene=scene), bench=bench)

    name, others = ("cross", ("my_module:solve",)) if where == "options" else ("refinement", ())
    found = studied(name, raising, *others)
    assert "not on this grid" in found.attrs.pop("failures")
    assert found.identical(studied(name, *others))
    if where == "options":
        with pytest.raises(SolvesFailed, match="not on this grid"):
            studied(name, raising)


def test_of_the_methods_of_a_scene_a_study_keeps_those_that_are_named_by_their_solver(own_module):
    options = find_study("refinement").parse(["--surfaces", "2"], scene=own_scene("my_module:solve"))
    kept, left = (options._with_methods(("bem", *more)).scene.methods for more in (("my_module:solve",), ()))
    assert kept.own.solver == "my_module:solve"
    assert left.own is None


#: Options of a study of a second.
FEW = ("--surfaces", "2", "--bandwidth", "2", "--method-points-per-wave", "3,4")

LATE, CRASHED = "took more than 2 s", "crashed its process"
#: What a solver may do, and what is said of it.
MISDEEDS = {
    "raises": ("raise ValueError('no such thing')", "raised ValueError: no such thing"),
    "crashes": ("import os; os.abort()", CRASHED + r" \(SIGABRT\)"),
    "sleeps": ("import time; time.sleep(600)", LATE),
    "shape": ("return np.zeros((2, 2))", r"shape \(2, 2\): must have that of the heights"),
    "nan": ("return np.full(heights.shape, np.nan)", "pressures are not finite"),
    "load": ("return np.full(heights.shape, 2 * mean_pressure)", "above the tolerance"),
    "starts": ("import subprocess as s; s.Popen(['sleep', '600'])\nwhile True: pass", LATE),
}
NIGHTLY_MISDEEDS = {
    "complex": ("return np.full(heights.shape, 1j)", "Cannot cast array data from .*complex128"),
    "lines": ("raise ValueError('one\\ntwo\\nthree' * 999)", "one"),
    "strange": ("raise type('Strange', (Exception,), {'__str__': lambda e: 1 / 0})", CRASHED),
    "private": ("raise type('Private', (BaseException,), {})", "raised RuntimeError: Private"),
    "interrupts": ("raise KeyboardInterrupt", "raised RuntimeError: KeyboardInterrupt"),
    "stops": ("import os, signal as s; os.kill(os.getpid(), s.SIGSTOP)", LATE),
    "recurs": ("return solve(heights, lengths, contact_modulus=1, mean_pressure=1)", "RecursionError"),
    "closes files": ("import os; os.closerange(0, 99)", CRASHED),
    "deaf": ("import signal as s\ns.signal(s.SIGTERM, s.SIG_IGN)\nwhile True: pass", LATE),
    "forks and dies": ("import os, time\nif not os.fork(): time.sleep(600)\nos.abort()", r"\(SIGABRT\)"),
    "detaches": (
        "import subprocess as s; s.Popen(['sleep', '600'], start_new_session=True)\nwhile True: pass",
        LATE,
    ),
}
#: What it may do beside, and its pressures are right.
HARMLESS = {
    "forks": "import os, time\nif not os.fork(): time.sleep(600)",
    "prints": "print('x' * 2**20); import os; os.write(2, b'y' * 2**20)",
    "closes output": "import os; os.close(1); os.close(2)",
    "changes folder": "import os; os.chdir('/')",
    "changes its input": "kept = heights.copy(); heights[:] = 0; heights = kept",
    "raises at errors": "np.seterr(all='raise')",
    "seeds": "import random; random.seed(1); np.random.seed(1)",
    "leaves threads": "import threading as t, time; t.Thread(target=time.sleep, args=(600,)).start()",
    "clears the temporary folder": "import os, shutil; shutil.rmtree(os.environ['TMPDIR'])",
}
RIGHT = """
import my_module
return my_module.solve(heights, lengths, contact_modulus=contact_modulus, mean_pressure=mean_pressure)
"""


def started_under(mark):
    """Every process that has a mark in its environment."""
    marked = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            marked += [process] if process.environ().get("MISDEED") == mark else []
    return marked


@pytest.fixture
def unharmed(own_module, monkeypatch):
    """Nothing is left of a solver: no process, no change of this one."""
    sandbox.end()  # a new process has this environment
    (own_module / "temporary").mkdir()
    monkeypatch.setenv("TMPDIR", str(own_module / "temporary"))
    monkeypatch.setenv("MISDEED", str(own_module))
    before = random.getstate(), np.geterr(), Path.cwd()
    yield
    assert not still_running(started_under(str(own_module)), seconds=2)
    assert (random.getstate(), np.geterr(), Path.cwd()) == before


def nightly(names):
    return [pytest.param(name, marks=pytest.mark.nightly) for name in names]


@pytest.mark.parametrize("name", [*MISDEEDS, *nightly(NIGHTLY_MISDEEDS)])
def test_what_goes_wrong_in_a_foreign_solver_is_a_line_and_its_processes_end(unharmed, name):
    body, says = {**MISDEEDS, **NIGHTLY_MISDEEDS}[name]
    with refused(NotConverged, says) as told:
        pressed(written(name.replace(" ", "_"), body), seconds=2.0 if says is LATE else 5.0).checked()
    assert len(str(told.value)) < 1000
    if "process" not in str(told.value) and "took more" not in str(told.value):
        sandbox.end()


@pytest.mark.parametrize("name", nightly(HARMLESS))
def test_what_a_foreign_solver_does_beside_spoils_neither_its_pressures_nor_the_next_one(unharmed, name):
    reference = find_solver("bem").solve(job(tolerance=1e-10)).contact
    for function in (written(name.replace(" ", "_"), HARMLESS[name] + RIGHT), "my_module:solve"):
        assert np.array_equal(pressed(function, seconds=60.0).checked().in_contact, reference.in_contact)
    sandbox.end()


def test_the_edge_of_a_foreign_contact_is_located_though_a_haze_of_pressure_lies_around_it(own_module):
    haze = RIGHT.replace("return", "p =") + "return np.maximum(p, 1e-15 * mean_pressure)"
    contact = pressed(written("haze", haze)).checked()
    assert np.all(contact.pressure > 0)
    reference = find_solver("bem").solve(job(tolerance=1e-10))
    found = contact_areas(contact, subcell=True)
    assert np.array_equal(contact.in_contact, reference.contact.in_contact)
    assert found.subcell == pytest.approx(contact_areas(reference.contact, subcell=True).subcell, rel=1e-4)


def test_foreign_solvers_stand_after_the_others():
    solvers = [method for method in methods().values() if isinstance(method, Solver)]
    flags = [solver.foreign for solver in solvers]
    assert flags == sorted(flags)


HANDLED = {
    "own": set(),
    "tamaas": {"hardness"},
    "contact_mechanics": {"hardness", "thickness"},
    "calculix": {"thickness"},
}


@pytest.mark.parametrize("name", HANDLED)
def test_foreign_solvers_are_given_what_they_can_be_given(name):
    kinds = [kind for kind in effect_kinds().values() if find_method(name).handles(kind)]
    assert {kind.kind_name() for kind in kinds} == HANDLED[name]


def test_a_layer_that_slides_on_its_base_is_refused_by_name(tmp_path):
    effect = '[[effects]]\nkind = "thickness"\nthickness = 2e-6\nbase = "frictionless"\n'
    text = small_scene(effect, grids="[16]").replace("methods.bem", "methods.contact_mechanics")
    scene = scene_in(tmp_path, text)
    options, peer = scene.methods.options("contact_mechanics"), find_method("contact_mechanics")
    with pytest.raises(UsageError, match=r"\[\[effects\]\] 1 kind = 'thickness'.*'contact_mechanics'"):
        peer.check(options, realise(scene), scene.effects)


@pytest.mark.parametrize(
    ("length", "grid", "wrong"),
    [
        ('"10 um"', "[16, 16]", False),
        ('"10 um"', "[24, 16]", True),
        ('"10 um"', "[16, 24]", True),
        ('["10 um", "5 um"]', "[16, 16]", True),
    ],
)
def test_aspher_is_asked_for_squares_alone(tmp_path, length, grid, wrong):
    text = square_scene(length=length, grids=f"[16, {grid}]").replace("methods.bem", "methods.aspher")
    scene = scene_in(tmp_path, text)
    options, problem = scene.methods.options("aspher"), realise(scene)
    squares = partial(pytest.raises, match="ASPHER has square grids on square periods")
    with squares(UsageError) if wrong else contextlib.nullcontext():
        find_method("aspher").check(options, problem, ())
    if wrong:
        heights = np.zeros(options.grids[1])
        with squares(ValueError):
            aspher.solve(heights, problem.lengths, contact_modulus=1.0, mean_pressure=0.1, tolerance=1e-6)


def test_a_method_that_takes_no_job_is_refused_by_name(monkeypatch):
    class Old(Bem):
        def solve(self, field, *, mean_pressure, model, settings, threads=None): ...

    monkeypatch.setattr("validation.solvers.found_in", lambda *_, **__: (Old,))
    with pytest.raises(UsageError, match=r"method 'bem' of .*: its `solve` takes one `job` now"):
        methods.__wrapped__()


@pytest.mark.parametrize("name", ["tamaas", "contact_mechanics"])
def test_a_peer_that_is_missing_says_what_to_install(name, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda package: None)
    assert "pip install 'fem-contact[peers]'" in str(find_method(name).available())


def installed(name):
    if (missing := find_solver(name).available()) is not None:
        pytest.skip(missing)
    return find_solver(name)


@pytest.mark.parametrize(
    ("name", "tolerance", "apart"), [("tamaas", 1e-10, 1e-6), ("contact_mechanics", 1e-9, 1e-4)]
)
@pytest.mark.parametrize("load", [1e-4, 0.1])
def test_a_peer_agrees_with_boundary_elements(name, tolerance, apart, load):
    peer = installed(name)
    solid = Solid(young=2e9, poisson=0.3)
    asked = job(load * solid.contact_modulus, points=64, model=ContactModel(solid=solid), tolerance=tolerance)
    small = HeightField(heights=1e-6 * asked.field.heights[:, ::2], lengths=(1e-6, 1.3e-6))
    asked = replace(asked, field=small)
    ours = find_solver("bem").solve(asked).contact.checked()
    found = peer.solve(asked).contact.checked()
    assert np.array_equal(found.in_contact, ours.in_contact)
    pressures = [found.pressure]
    if not ours.in_contact.all():  # then no offset tells how hard it is pressed
        pressures.append(peer.claim(replace(asked, load={"offset": ours.offset})).pressure)
    for pressure in pressures:
        assert np.linalg.norm(pressure - ours.pressure) < apart * np.linalg.norm(ours.pressure)


@pytest.mark.parametrize("name", ["tamaas", "contact_mechanics"])
def test_the_audit_locates_the_edges_of_a_peer_that_comes_first(name, tmp_path):
    installed(name)
    scene = scene_in(tmp_path, square_scene("[methods.theory]").replace("methods.bem", f"methods.{name}"))
    outputs = run_scene(scene, tmp_path / "run", report=False)
    assert "located" in outputs.result.data.area_basis.item()
    assert not audit(outputs.folder).wrong


@pytest.mark.parametrize(
    ("name", "effect"),
    [
        ("tamaas", Hardness(hardness=0.06)),
        ("contact_mechanics", Hardness(hardness=0.06)),
        ("contact_mechanics", Thickness(thickness=0.1)),
    ],
)
def test_a_peer_with_an_effect_agrees_with_boundary_elements(name, effect):
    peer = installed(name)
    model = ContactModel.filled(Solid(young=1.0, poisson=0.3), [effect])
    asked = job(0.02, points=64, model=model, tolerance=1e-9)
    found, ours = (solver.solve(asked) for solver in (peer, find_solver("bem")))
    theirs = found.contact.checked()
    # An energy error of the tolerance leaves its square root in the pressure.
    apart = np.linalg.norm(theirs.pressure - ours.contact.pressure)
    assert apart < 1e-4 * np.linalg.norm(ours.contact.pressure)
    assert np.array_equal(theirs.at_bound, ours.contact.at_bound)
