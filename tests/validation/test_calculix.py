"""The block by CalculiX beside our own full finite elements, on one mesh."""

import os
from pathlib import Path

import numpy as np
import pytest

from fem_contact.errors import NotConverged
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.effects.base import ContactModel
from validation.solvers import find_solver
from validation.solvers.base import Job, example_field

CALCULIX, FEM = find_solver("calculix"), find_solver("fem")
present = pytest.mark.skipif(CALCULIX.available() is not None, reason=str(CALCULIX.available()))


def pressed(solver, field: HeightField, load: float, solid: Solid, **settings):
    load = {"mean_pressure": load * solid.young}
    return solver.solve(
        Job(field=field, load=load, model=ContactModel(solid=solid), settings=settings)
    ).contact


@present
@pytest.mark.parametrize(
    ("shape", "lengths", "poisson", "load"),
    [
        ((12, 12), (1e-4, 1e-4), 0.3, 0.02),
        ((8, 12), (1e-4, 2e-4), 0.0, 0.01),
        ((12, 12), (1.0, 1.0), 0.3, 0.3),
        ((12, 12), (1.0, 1.0), 0.3, 1e-4),
    ],
)
def test_calculix_and_our_full_block_agree_in_nodal_forces(
    shape: tuple[int, int], lengths: tuple[float, float], poisson: float, load: float
) -> None:
    unit = example_field(32).resampled(shape)
    field = HeightField(heights=unit.heights * lengths[0], lengths=lengths)
    solid = Solid(young=2e9, poisson=poisson)
    theirs = pressed(CALCULIX, field, load, solid).checked()
    ours = pressed(FEM, field, load, solid, tolerance=1e-10).checked()
    # A closed gap gives by F / K, with K a million times the stiffness of a cell; 7 digits are printed.
    assert np.linalg.norm(theirs.pressure - ours.pressure) < 5e-6 * np.linalg.norm(ours.pressure)
    assert np.array_equal(theirs.in_contact, ours.in_contact)
    assert theirs.offset == pytest.approx(ours.offset, abs=1e-6 * np.abs(ours.displacement).max())


@present
def test_time_that_is_over_is_said() -> None:
    solid = Solid(young=1.0, poisson=0.3)
    with pytest.raises(NotConverged, match=r"took more than 0\.01 s"):
        pressed(CALCULIX, example_field(16), 0.01, solid, seconds=0.01)


def test_a_missing_program_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert "apt install calculix-ccx" in str(CALCULIX.available())


@pytest.mark.skipif(os.name == "nt", reason="a shell script stands in for the program")
def test_a_program_that_fails_is_quoted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "ccx"
    program.write_text("#!/bin/sh\necho ' *ERROR in something: no'\nexit 201\n", encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    with pytest.raises(NotConverged, match=r"\*ERROR in something: no"):
        pressed(CALCULIX, example_field(16), 0.01, Solid(young=1.0, poisson=0.3))
