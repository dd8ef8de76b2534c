"""The catalogue of faults: each still applies exactly once, and, with `-m mutants`, each is noticed."""

from __future__ import annotations

import ast
import importlib.util
import sys
from pathlib import Path

import pytest

from validation import cases
from validation.cases import Case, relative

_SPEC = importlib.util.spec_from_file_location("mutants_driver", Path(__file__).with_name("driver.py"))
driver = importlib.util.module_from_spec(_SPEC)
sys.modules["mutants_driver"] = driver
_SPEC.loader.exec_module(driver)

MUTANTS = driver.catalogue()


def test_each_fault_applies_exactly_once_and_leaves_python():
    wrong = []
    for mutant in MUTANTS:
        try:
            changed = mutant.applied((driver.ROOT / mutant.file).read_text(encoding="utf-8"))
            assert mutant.old != mutant.new, f"{mutant.name}: changes nothing"
            compile(changed, mutant.file, "exec", ast.PyCF_ONLY_AST)
        except (ValueError, SyntaxError, OSError, AssertionError) as error:
            wrong.append(f"{mutant.name}: {error}")
    assert wrong == []


def test_the_tests_that_faults_name_exist():
    known: dict[str, str] = {}
    for test in {test for mutant in MUTANTS for test in mutant.tests}:
        path, *function = test.split("::")
        text = known.setdefault(path, (driver.ROOT / path).read_text(encoding="utf-8"))
        if function:
            assert f"def {function[0].split('[')[0]}(" in text, test


def test_names_tell_faults_apart_and_every_package_has_some():
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS)
    assert {mutant.file.split("/")[0] for mutant in MUTANTS} == set(driver.PACKAGES)
    excused = [mutant.name for mutant in MUTANTS if mutant.survives]
    assert len(excused) <= 0.05 * len(MUTANTS), excused


def test_a_fault_whose_text_is_gone_is_refused_by_name():
    mutant = driver.Mutant(name="lost", file="x.py", old="a", new="b", tests=())
    with pytest.raises(ValueError, match=r"lost: 'a' stands 2 times in x\.py, must stand once"):
        mutant.applied("a a")


def test_validate_is_asked_about_a_fault_by_the_cases_that_call_its_function_and_else_by_all():
    text = "LIMIT = 1\n\n\ndef outer(x):\n    def inner(y):\n        return y\n\n    return inner(x) + 2\n"
    known = driver.Cases(
        reached={"one": {("a.py", 4), ("a.py", 5)}, "two": {("a.py", 4)}, "three": set()},
        seconds={"one": 3.0, "two": 2.0, "three": 1.0},
        checks={},
    )  # fmt: skip

    def chosen(old, new, **changes):
        mutant = driver.Mutant(name="m", file="a.py", old=old, new=new, tests=(), **changes)
        return known.that_call(mutant, text)

    assert chosen("return y", "return -y") == ["one"]
    assert chosen("inner(x) + 2", "inner(x) + 3") == ["two", "one"]
    assert chosen("return y\n\n    return inner(x) + 2", "return y\n\n    return inner(x) + 3") == [
        "two",
        "one",
    ]
    assert chosen("LIMIT = 1", "LIMIT = 2") == ["three", "two", "one"]
    assert chosen("return y", "return -y", kernel=True) == ["three", "two", "one"]


def test_a_case_that_fails_is_named_with_its_check(monkeypatch, capsys):
    spec = importlib.util.spec_from_file_location(
        "validate_cases", Path(__file__).with_name("validate_cases.py")
    )
    validate_cases = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(validate_cases)
    wrong = Case(name="wrong", claim="Two is three.", run=lambda: [relative("two", 2.0, 3.0, 0.01)])
    right = Case(name="right", claim="Two is two.", run=lambda: [relative("two", 2.0, 2.0, 0.01)])
    monkeypatch.setattr(cases, "all_cases", lambda: (right, wrong))
    assert validate_cases.run(["right"]) == 0
    assert validate_cases.run(["right", "wrong"]) == 1
    assert capsys.readouterr().out == "FAILED wrong - two: 2 for 3 +- 0.03\n"


@pytest.fixture(scope="module")
def tree():
    with driver.copied_tree() as made:
        yield made


@pytest.mark.mutants
def test_without_a_fault_the_named_tests_pass(tree):
    named = sorted({test for mutant in MUTANTS for test in mutant.tests})
    code, output = driver.run_tests(tree, named, cache=tree.parent / "cache", limit=1800)
    assert code == 0, output[-2000:]


@pytest.mark.mutants
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_each_fault_is_noticed(mutant, tree):
    outcome = driver.judge(mutant, tree)
    assert outcome.verdict == ("survived" if mutant.survives else "killed"), outcome.output[-2000:]
