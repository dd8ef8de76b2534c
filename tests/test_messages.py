"""A check takes what it allows to the last number, and its message names the argument that it is about."""

import ast
import re
from pathlib import Path

import numpy as np
import pytest

import fem_contact
import persson
from contact_checks import UNITS
from fem_contact import _checks
from persson import _checks as _checks_of_theory

CHECKS = {*vars(_checks), *vars(_checks_of_theory)}


def checked(function):
    """Return the word and the argument of what each check of an argument or attribute is told of."""
    own = {argument.arg for argument in (*function.args.args, *function.args.kwonlyargs)}
    found = []
    for call in ast.walk(function):
        match call:
            case ast.Call(func=ast.Name(id=check), args=[ast.Constant(value=word), value, *_]) if (
                check in CHECKS or check.startswith("check")
            ):
                match value:
                    case ast.Attribute(value=ast.Name(id="self"), attr=name):
                        found.append((word, name))
                    case ast.Name(id=name) if name in own:
                        found.append((word, name))
    return found


def nodes():
    for package in (fem_contact, persson):
        for path in Path(package.__file__).parent.rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                yield path.name, node


def test_the_message_of_a_check_names_its_argument():
    found = []
    for file, node in nodes():
        # A private function may be told the name that its caller knows it by.
        if isinstance(node, ast.FunctionDef) and (
            not node.name.startswith("_") or node.name == "__post_init__"
        ):
            found += [(file, node.name, *pair) for pair in checked(node)]
    assert len(found) > 200
    assert [one for one in found if one[2] != one[3]] == []


@pytest.mark.parametrize("value", [_checks.LEAST, _checks.GREATEST])
@pytest.mark.parametrize("check", [_checks.finite, _checks.non_negative, _checks.positive])
def test_a_check_takes_the_least_and_the_greatest_that_it_names(check, value):
    assert check("depth", value) == value
    assert _checks.bound("bound", value) == value
    assert (_checks.array("heights", np.full(3, value)) == value).all()
    outside = np.nextafter(value, 0.0 if value < 1 else np.inf)
    with pytest.raises(fem_contact.InvalidInput, match="depth"):
        check("depth", outside)


def test_the_unit_of_a_message_is_that_of_the_documentation():
    entry = re.compile(r"^(\w[\w, ]*) : .*\n((?:    .*\n?)+)", re.MULTILINE)
    documented = [node for _, node in nodes() if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    texts = [ast.get_docstring(node) or "" for node in documented]
    told = [pair for text in texts for pair in entry.findall(text.partition("Attributes\n")[0])]
    each = [(name, text) for names, text in told for name in names.split(", ")]
    units = [(name, text) for name, text in each if name in UNITS and "[" in text]
    assert len(units) > 150
    assert [(name, text) for name, text in units if f"[{UNITS[name]}" not in text] == []
