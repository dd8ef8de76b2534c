"""The study of sliding: its numbers are the surface's, its sentences the numbers'."""

import pytest
from gold.asked import STUDIES

from fem_contact import PronySolid, slide
from validation.errors import UsageError
from validation.measurements.common import base_case
from validation.measurements.measurement import grid_for
from validation.scenes.tables import SolidSpec
from validation.studies import find_study, sliding
from validation.studies import sliding as measure


@pytest.fixture(scope="module")
def slid(asked):
    return asked("sliding")


def test_the_friction_of_the_study_is_that_of_the_surface_on_each_grid(slid):
    options, data = slid
    solid = PronySolid.standard(relaxed=1e6, unrelaxed=1e7, time=1e-3, poisson=0.5)
    surface, relaxed = options.self_affine(length=options.length), SolidSpec(young=1e6, poisson=0.5)
    case = base_case(surface, reduced_pressure=0.1, solid=relaxed).further(1)
    for g, points in enumerate(options.points_per_wave):
        heights = case.heights(grid_for(case, points))
        own = slide(heights, solid, velocity=2.0, mean_pressure=case.pressure, threads=1)
        rough, found = case.field.rms_gradient, data.isel(surface=1, grid=g, velocity=1)
        assert float(found.friction_grid_each) == pytest.approx(own.slopes / rough, rel=1e-5)
        assert float(found.friction_dissipated_grid_each) == pytest.approx(own.dissipation / rough, rel=1e-5)


def test_the_theory_of_the_study_is_told_the_realised_waves(slid):
    """At a load that closes the gap the theory is exact, whatever the surface."""
    _, data = slid
    full = sliding.Options(**(STUDIES["sliding"] | {"reduced_pressure": 40.0, "velocities": (0.05,)}))
    rubber, relaxed = full.rubber(), SolidSpec(young=1e6, poisson=0.5)
    case = base_case(full.self_affine(length=full.length), reduced_pressure=40.0, solid=relaxed)
    theory = measure._theory(case, rubber, (0.05,))
    own = slide(case.heights((32, 32)), rubber, velocity=0.05, mean_pressure=case.pressure, threads=1)
    for name, (_, (value,)) in theory.items():
        rubs = name.startswith("friction")
        exact = own.friction / case.field.rms_gradient if rubs else 1.0
        assert value == pytest.approx(exact, rel=1e-5 if rubs else 1e-9), name
    assert (data.friction_half_energy < data.friction_full_energy).all()


def test_the_error_of_the_grid_is_the_step_to_the_finest_or_by_how_much_both_frictions_differ(slid):
    _, data = slid
    finest = data.isel(grid=-1)
    apart = finest.friction_grid_each - finest.friction_dissipated_grid_each
    for name, other in (("friction", apart), ("friction_dissipated", -apart), ("area", 0 * apart)):
        step = data[f"{name}_grid_each"].diff("grid").isel(grid=-1)
        larger = step.where(abs(step) > abs(other), other)
        own = ((larger**2).mean("surface") / larger.sizes["surface"]) ** 0.5  # of a mean of such sizes
        grid, exact = data[f"{name}_error"].sel(source="grid"), (larger.mean("surface") ** 2 + own**2) ** 0.5
        assert grid.values == pytest.approx(exact.values, rel=1e-12), name


def test_one_solid_is_given_with_units(tmp_path):
    study = find_study("sliding")
    series = study.parse(["--moduli", "9 MPa,1 GPa", "--times", "1 ms,1 us", "--relaxed", "1 MPa"])
    assert series.rubber().unrelaxed == pytest.approx(1.01e9)
    file = tmp_path / "modulus.txt"
    file.write_text("# omega E' E''\n1 1e6 1e5\n1e6 1e9 1e8\n", encoding="utf-8")
    table = study.parse(["--modulus-table", str(file), "--velocities", "1 mm/s,2 cm/s"])
    assert table.velocities == (1e-3, 0.02)
    assert table.rubber().storage == (1e6, 1e9)
    both = ["--moduli", "1 MPa", "--times", "1 s"]
    others = (["--unrelaxed", "1 GPa"], ["--relaxed", "1 MPa"], ["--time", "1 ms"], both)
    for arguments, words in (
        *((["--modulus-table", str(file), *other], "give one solid") for other in others),
        (["--moduli", "1 MPa"], "must be as many"),
        (["--velocities", "2 m/s,1 m/s"], "rising"),
        (["--velocities", "2 m"], "is not a velocity"),
    ):
        with pytest.raises(UsageError, match=words):
            study.parse(arguments)
    file.write_text("1 2\n", encoding="utf-8")
    with pytest.raises(UsageError, match="must hold lines of omega"):
        table.rubber()
