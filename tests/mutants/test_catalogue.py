"""The catalogue of faults: each still applies exactly once, and, with `-m mutants`, each is noticed."""

import ast
import importlib.util
import json
import sys
from pathlib import Path

import pytest

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


def test_a_fault_of_the_catalogue_breaks_each_check_of_validate():
    table = json.loads(Path(__file__).with_name("checks.json").read_text(encoding="utf-8"))
    names = {mutant.name for mutant in MUTANTS}
    assert [place for place, checks in table.items() if not names >= {*checks.values()}] == []


def test_each_test_of_the_audit_is_broken_by_a_fault_of_the_audit():
    faults = [mutant for mutant in MUTANTS if mutant.file.startswith("validation/audit/")]
    # Alone, so that it is this test that breaks.
    alone = {mutant.tests[0].partition("[")[0] for mutant in faults if len(mutant.tests) == 1}
    assert driver.tests_of_audit() - alone == set()


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
