"""Whatever is handed to a public function: an answer, or one of the package's own exceptions in one line."""

import importlib.util
import inspect
import itertools
import math
import re
import signal
from collections import Counter
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from public_api import block_doors, solver_doors
from public_api_of_theory import theory_doors

from fem_contact import FemContactError, bem, face, random_surface
from fem_contact.settings import Settings
from persson import PerssonError

#: Modules whose public names are all public_api, or results, constants and types that need none.
FEM = solver_doors() | {f"block.{name}": door for name, door in block_doors().items()}
THEORY = theory_doors()
ALL = FEM | {f"persson.{name}": door for name, door in THEORY.items()}

#: Processor seconds: more than the slowest sensible call takes, less than a hang.
PATIENCE = 60

GRID = (12, 12)
OTHERS = [
    None,
    "x",
    "1.0",
    b"",
    True,
    False,
    1j,
    {},
    object(),
    10**400,
    2**63,
    2**31,
    int(1e30),
    1e30,
    5e-324,
    1e-320,
    1e300,
    -1e300,
    math.nan,
    math.inf,
    -math.inf,
    0,
    0.0,
    -1.0,
    [],
    (),
    [object()],
    [[1.0, 2.0], [3.0]],
    (1.0, "a"),
    (1e30, 1e-30),
    (2, 2**40),
    (10**5, 10**5),
    np.array([]),
    np.array(["a"]),
    np.array([None]),
    np.array(0.5),
    np.float32(0.5),
    np.datetime64("2020-01-01"),
    np.zeros((2, 2, 2)),
    np.zeros(GRID),
    np.ones(GRID),
    -np.ones(GRID),
    np.full(GRID, np.nan),
    np.full(GRID, 1e300),
    np.full(GRID, 5e-324),
    np.ones(GRID, dtype=complex),
    np.ones(GRID, dtype=bool),
    np.ones(GRID, dtype=object),
    np.ma.masked_array(np.ones(GRID), mask=np.eye(12)),
    lambda *_: None,
    lambda *_: "x",
    lambda *a: a[0] * math.nan,
    lambda *a: -np.abs(a[0]),
    lambda *a: a[0] * 1e300,
]

#: Numbers of every size, small whole ones among them, sequences, and the zoo above.
HOSTILE = st.one_of(
    st.sampled_from(OTHERS),
    st.floats(),
    st.floats(1e-12, 1e12),
    st.integers(-3, 40),
    st.integers(),
    st.text(max_size=5),
    st.lists(st.floats(), max_size=4),
    st.lists(st.floats(1e-6, 1e6), min_size=1, max_size=4),
    st.tuples(st.floats(), st.floats()),
)


#: By name: what fails is printed with its arguments, and all public_api would be too long.
DOORS = {"fem_contact": FEM, "persson": THEORY}


class Hangs(BaseException):
    """Not an Exception: no code under test swallows it."""


@contextmanager
def bounded_time():
    def stop(*_):
        raise Hangs

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def knock(door, changes):
    """Call with some arguments replaced: any answer is welcome, and no exception but the packages' own."""
    function, valid = door
    try:
        with bounded_time():
            return function(**(valid | changes))
    except (FemContactError, PerssonError) as error:
        refusal = str(error)
    assert refusal
    assert "\n" not in refusal
    return None


@pytest.mark.parametrize("name", ALL)
def test_every_door_opens_to_sensible_arguments(name):
    function, valid = ALL[name]
    function(**valid)


@pytest.mark.parametrize("package", DOORS)
@settings(max_examples=400, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_whatever_is_handed_in_nothing_but_the_packages_own_exceptions_comes_out(package, data):
    doors = DOORS[package]
    door = doors[data.draw(st.sampled_from(sorted(doors)), label="door")]
    names = data.draw(st.lists(st.sampled_from(sorted(door[1])), min_size=1, max_size=3, unique=True))
    knock(door, {name: data.draw(HOSTILE, label=name) for name in names})


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_every_argument_of_every_door_meets_every_hostile_value(name):
    door = ALL[name]
    for argument in door[1]:
        for value in OTHERS:
            knock(door, {argument: value})


def refusal_of(door, changes):
    try:
        door[0](**(door[1] | changes))
    except (FemContactError, PerssonError) as error:
        return str(error)
    return ""


@pytest.mark.parametrize("package", DOORS)
@pytest.mark.parametrize("value", ["x", math.nan, -1.0])
def test_a_refusal_names_the_argument_that_is_wrong(package, value):
    wrong = []
    for name, door in DOORS[package].items():
        for argument in door[1]:
            said = refusal_of(door, {argument: value})
            wrong += [] if not said or re.search(rf"\b{argument}\b", said) else [(name, argument)]
    assert wrong == []


@pytest.mark.parametrize("package", DOORS)
def test_what_lies_just_outside_of_a_range_that_is_stated_is_refused(package):
    stated, wrong = 0, []
    for name, door in DOORS[package].items():
        for argument in door[1]:
            said = refusal_of(door, {argument: -1e29})
            ends = re.search(rf"\b{argument}\b.*lie in ([\[(])([-+.\de]+), ([-+.\de]+)([\])])", said)
            for bracket, number, sign in ((*ends.group(1, 2), -1), (*ends.group(4, 3), 1)) if ends else ():
                stated += 1
                end = float(number)
                outside = [end + sign * (1e-3 * abs(end) + 1e-9), *([end] if bracket in "()" else [])]
                taken = [value for value in outside if argument not in refusal_of(door, {argument: value})]
                wrong += [(name, argument, *taken)] if taken else []
    assert wrong == []
    assert stated > 20


#: How many doors take what is no number, no positive one, or nothing; by argument.
TAKEN = (
    ("x", {"axis": 3}),
    ({}, {"breaks": 2, "mean_pressures": 3, "slopes": 1, "wavelengths": 1}),
    (True, {"subcell": 1, "under_resolved": 1}),
    (1j, {}),
    (math.nan, {}),
    (math.inf, {"contact_size": 1, "second": 1, "tensile_limit": 2, "yield_stress": 1}),
    (
        -1.0,
        {"distance": 1, "edge_constant": 1, "gap": 7, "height": 1, "mean_gap": 1, "mean_pressure": 1}
        | {"offset": 3, "pressure": 4, "q": 3, "qx": 8, "qy": 8, "separation": 4, "stress": 6}
        | {"target_pressure": 1, "velocity": 3, "work": 1},
    ),
    (
        0.0,
        {"area": 4, "barrier": 1, "contact_modulus": 1, "contact_radius": 1, "depth": 2, "dissipation": 2}
        | {"distance": 2, "edge_constant": 1, "exponent": 1, "force": 4, "frequency": 4, "gap": 7}
        | {"height": 1, "hurst": 3, "least_jump": 1, "length": 1, "m2": 2, "magnification": 1, "mean_gap": 1}
        | {"mean_pressure": 1, "nominal": 1, "offset": 4, "poisson": 13, "pressure": 18, "q": 5}
        | {"q_gravity": 1, "q_min": 3, "q_upper": 13, "qx": 8, "qy": 8, "ramp": 1, "reduced_pressure": 1}
        | {"rms_gradient": 1, "separation": 4, "shear_stress": 1, "stress": 6, "stress_variance": 10}
        | {"target_pressure": 1, "tensile_limit": 5, "time": 1, "variance": 3, "velocity": 3}
        | {"wavevector": 3, "wavevectors": 1, "work": 2},
    ),
)


@pytest.mark.parametrize(("value", "taken"), TAKEN, ids=[str(value) for value, _ in TAKEN])
def test_what_is_no_sensible_number_is_refused_but_where_it_means_something(value, taken):
    arguments = [(argument, door) for door in ALL.values() for argument in door[1]]
    assert Counter(name for name, door in arguments if not refusal_of(door, {name: value})) == taken


def numbers_of(door):
    return [name for name, value in door[1].items() if type(value) in (int, float)]


#: Large numbers that decay, or are capped.
CAPPED = {"amplitude", "growth", "tensile_limit", "yield_stress"}


@pytest.mark.parametrize(
    ("value", "computable"),
    # The others are squares of pressures, and a time.
    [(1e45, CAPPED | {"m2", "stress_variance", "variance", "time"}), (1e75, CAPPED)],
)
def test_numbers_beyond_what_can_be_computed_with_are_refused(value, computable):
    numbers = [(argument, door) for door in ALL.values() for argument in numbers_of(door)]
    assert {name for name, door in numbers if not refusal_of(door, {name: value})} == computable


@pytest.mark.parametrize("package", DOORS)
def test_arrays_that_do_not_broadcast_are_refused(package):
    pairs = 0
    for door in DOORS[package].values():
        arrays = [n for n in numbers_of(door) if not refusal_of(door, {n: np.full(2, float(door[1][n]))})]
        for one, other in itertools.combinations(arrays, 2):
            pairs += 1
            both = {one: np.full(2, float(door[1][one])), other: np.full(3, float(door[1][other]))}
            assert refusal_of(door, both), (door[0], one, other)
    assert pairs or package == "fem_contact"


def test_all_linear_solvers_are_as_exact_unless_told_otherwise():
    defaults = {
        name: inspect.signature(door[0]).parameters["tolerance"].default
        for name, door in FEM.items()
        if "tolerance" in getattr(inspect.signature(door[0]), "parameters", {})
        and door[0].__module__.split(".")[1] in {"bem", "block", "creeping", "hardness", "sliding"}
    }
    assert len(defaults) > 5
    others = {name for name, value in defaults.items() if value != Settings().tolerance}
    assert others <= {"block.assembled_field"}


def test_a_surface_in_slabs_is_drawn_as_a_whole_one_unless_told_otherwise():
    both = [inspect.signature(door).parameters for door in (bem.SlabSurface.random, random_surface)]
    slabs, whole = ({name: one.default for name, one in parameters.items()} for parameters in both)
    shared = slabs.keys() & whole.keys()
    assert {name: slabs[name] for name in shared} == {name: whole[name] for name in shared}
    assert "isotropic" in shared


#: Made by the functions: no door of their own.
RESULTS = """
Residuals Cost ContactResult ContactAreas Limit Patches RadialSpectrum YieldedContact Moments
SpectrumMoments Diffusion SineExpansion BlockSolution CellStress Equilibrium FiniteStrain
FrozenContact GapFlow AtDepth Lay Strongest Subsurface SlidingContact SlidingFriction Estimate
WaveError
"""


@pytest.mark.parametrize("package", ["fem_contact", "fem_contact.block", "persson"])
def test_every_public_function_is_among_the_doors(package):
    module = importlib.import_module(package)
    called = [getattr(door[0], "__func__", door[0]) for door in ALL.values()]
    owners = [getattr(door[0], "__self__", None) for door in THEORY.values()]
    known = {id(function) for function in (*called, *owners)}
    parts = {"BlockMesh", "Element", "MeshOptions"}  # made by the block's own functions
    drawn = {"render_section", "render_surface", "write_block", "write_subsurface"}  # tests of their own
    for name in module.__all__:
        value = getattr(module, name)
        protocol = getattr(value, "_is_protocol", False)
        if (
            not callable(value)
            or protocol
            or name
            in {*RESULTS.split(), *drawn, *parts, *face.__all__}  # which tests/validation/test_facade.py has
            or (isinstance(value, type) and (issubclass(value, Exception) or hasattr(value, "__members__")))
        ):
            continue
        assert id(value) in known, f"{package}.{name} is behind no door of tests/public_api*.py"
