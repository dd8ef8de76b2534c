"""The public names of the two packages: each stands once, in the stub, and is imported when first asked."""

import pytest
from processes import run_python

import fem_contact
import persson
from fem_contact import face
from validation import notebook

both = pytest.mark.parametrize("package", [fem_contact, persson], ids=lambda package: package.__name__)


@both
def test_every_public_name_is_there_and_listed(package):
    for name in set(package.__all__) - set(face.__all__):
        value = getattr(package, name)
        assert getattr(value, "__name__", name).rpartition(".")[2] == name
    assert set(package.__all__) <= set(dir(package))


@both
def test_an_unknown_name_is_an_attribute_error(package):
    with pytest.raises(AttributeError, match="no_such_thing"):
        _ = package.no_such_thing


@pytest.mark.parametrize("name", sorted({*face.__all__} - {"main"}))
def test_the_names_of_a_notebook_are_those_of_the_package(name):
    assert getattr(fem_contact, name) is getattr(notebook, name)
    assert name in fem_contact.__all__


@pytest.mark.parametrize("line", ["fem_contact.press", "fem_contact.face.main()"])
def test_another_package_called_validation_is_refused_with_the_remedy(tmp_path, line):
    (tmp_path / "validation").mkdir()
    (tmp_path / "validation" / "__init__.py").write_text("def validate(): ...")
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import fem_contact.face; {line}"
    last = run_python("-c", code).stderr.strip().splitlines()[-1]
    assert str(tmp_path) in last
    assert "pip uninstall validation" in last


@pytest.mark.parametrize(
    ("line", "new"),
    [
        ("import validation.methods.tamaas", "validation.solvers"),
        ("from validation.solves.bench import Bench", "validation.execution"),
        ("from validation.measures import common", "validation.measurements"),
        ("from validation.scenes.realised import realise", "validation.scenes.problem"),
        ("from validation.effects.base import Slots", "called ContactModel"),
        ("from validation.effects.base import Told", "called TheoryInputs"),
        ("fem_contact.initial_slope", "called window_slope"),
    ],
)
def test_an_old_name_says_the_new_one(line, new):
    with pytest.raises((ImportError, AttributeError), match=new):
        exec(line)
