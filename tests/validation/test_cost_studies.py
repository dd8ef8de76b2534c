"""What accuracy costs: external_codes, memory, scaling with the grid, levels of grids."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from gold.asked import STUDIES

from fem_contact import HalfSpace, NotConverged, bem, contact_areas
from validation.measurements import by_solver, external_codes, ways
from validation.measurements.by_solver import beside_bem
from validation.measurements.common import base_case, base_surface
from validation.studies import accuracy_cost


@pytest.fixture(scope="module")
def costs(bench):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(accuracy_cost, "installed_peers", tuple)
        told = {**STUDIES["accuracy-cost"], "peer_points_per_wave": (4.0,)}
        return accuracy_cost.run(accuracy_cost.Options(**told), bench=bench)


def test_ways_of_one_surface_are_of_the_grids_and_shifts_they_are_named_by(monkeypatch):
    load, grid, shift = np.ogrid[:1, :3, :4]
    numbers = {name: 100.0 * k + 10 * grid + shift + load for k, name in enumerate(ways.AREAS)}
    ones = 1.0 + 0 * (shift + load)
    numbers |= {"seconds": (1 + grid) * ones, "peak_bytes": 2 ** (10 + grid) * ones}
    data = {name: (("load", "grid", "shift"), values) for name, values in numbers.items()}
    measured = xr.Dataset(data, coords={"points_per_wave": ("grid", [3.0, 4.0, 6.0])})
    monkeypatch.setattr(ways, "area_limits", lambda some: [[float(some.pixel.mean())]])
    told = {
        way.way: (float(way.area_each[0]), float(way.seconds), float(way.peak_bytes))
        for way in ways.ways_of_bem({0: measured})
    }
    assert told["BEM pixel, 4 per wave"] == (10.0, 2.0, 2.0**11)
    assert told["BEM pixel, 4 per wave, 4 shifts"] == (11.5, 8.0, 2.0**11)
    assert told["BEM limit, 4 to 6 per wave"] == (15.0, 5.0, 2.0**12)
    assert told["BEM limit, 3 to 6 per wave, 4 shifts"] == (11.5, 24.0, 2.0**12)


def test_a_front_in_time_and_one_in_memory_hold_no_beaten_way(costs):
    error = costs.area_deviation_rms.values
    for cost in ("seconds", "peak_bytes"):
        front = ways.pareto_front(costs, cost)
        price = costs[cost].values
        assert list(error[front]) == sorted(error[front], reverse=True)
        for k in front:
            assert not np.any((error < error[k]) & (price <= price[k]))


def test_the_leaner_of_equals_is_named_and_none_where_the_reference_does_not_tell_them(costs):
    plain = costs.drop_dims(["target", "front_seconds", "front_peak_bytes"])
    # Of ways that take as long, the leaner is named.
    for ordered in (plain, plain.isel(way=slice(None, None, -1))):
        tied = ways.chosen_ways(ordered.assign(seconds=0 * ordered.seconds + 1.0)).isel(target=0)
        assert float(tied.peak_bytes_fastest) == float(costs.peak_bytes_leanest[0])
    unknown = ways.chosen_ways(plain.assign(reference_rms=0.02))
    assert str(unknown.way_fastest[-1].item()).startswith("not determinable")
    far = {"reference_rms": 0.0, "area_deviation_rms": plain.area_deviation_rms + 1}
    none = ways.chosen_ways(plain.assign(far))
    assert set(none.way_fastest.values) == {"none of the ways tried"}
    assert none.seconds_fastest.isnull().all()


def test_peers_that_are_not_installed_are_left_out_with_a_word(costs):
    last = accuracy_cost.views(costs).findings[-1]
    assert last.values["it"].value == "aspher, ContactMechanics, tamaas"


def _way(costs, of, label, **changed):
    """A way of the study under another name, measured as a process."""
    one = costs.sel(way=[of])
    values = {name: one[name] * 0 + value for name, value in changed.items()}
    return one.assign(values).assign_coords(way=[label], process=("way", [1]))


def test_a_peer_is_held_against_the_same_area_and_the_same_measure_of_memory(costs):
    count = "BEM pixel, 6 per wave"
    own = costs.drop_dims(["target", "front_seconds", "front_peak_bytes"])
    theirs = _way(own, count, "tamaas pixel, 6 per wave", seconds=9.0, peak_bytes=3 * 2**20)
    twin = _way(own, count, "fem_contact pixel, 6 per wave", seconds=3.0, peak_bytes=2 * 2**20)
    both = xr.concat([own, theirs, twin], dim="way", data_vars="minimal", coords="minimal")
    both = ways.chosen_ways(
        both.assign_attrs(peers="tamaas", absent="", measured_by="tamaas 2, fem_contact 1")
    )
    *_, peer, how = accuracy_cost.views(both).findings
    assert peer.kind == "cost"
    told = {name: value.value for name, value in peer.values.items()}
    assert (told["code"], told["way"], told["seconds"]) == ("tamaas", "pixel, 6 per wave", 9.0)
    assert told["ratio_twin"] == pytest.approx(1 / 3, rel=2e-3)
    best = both.sel(way=told["best"])
    assert float(best.area_deviation_rms) <= told["off"]
    assert told["ratio"] == pytest.approx(float(best.seconds) / 9.0)
    assert how.values["it"].value == "tamaas 2, fem_contact 1"
    # Arrays and processes are never ranked together.
    names = both.way.values[ways.pareto_front(both, "peak_bytes")]
    assert {name.split()[0] for name in names} <= {"tamaas", "fem_contact"}
    assert not any("tamaas" in name for name in both.way_leanest.values)


def peer(code, *, seed=4177, grid_share=0.1):
    surface = base_surface(hurst=0.8, seed=seed, periods=2.0, bandwidth=4.0)
    method, settings = external_codes.asked_of(code)
    asked = {"method": method, "settings": settings, "grid_share": grid_share}
    return beside_bem(problem=base_case(surface, reduced_pressure=0.1), grid=(64, 64), **asked)


def test_a_peer_is_solved_no_further_than_its_grid_deserves():
    loose, exact = (peer(external_codes.THIS_CODE, grid_share=share).do() for share in (100.0, 0.0))
    assert 1e-2 == float(loose.tolerance) > float(exact.tolerance)
    assert abs(float(loose.pixel - loose.pixel_bem)) > float(exact.pixel - exact.pixel_bem) == 0.0


def test_the_memory_of_a_peer_is_that_of_all_its_tries(monkeypatch):
    own, asked, ended = peer(external_codes.THIS_CODE)["problem"], [], []
    field = own.heights((24, 24))
    ours = bem.solve(field, HalfSpace(solid=own.elastic), mean_pressure=own.pressure).checked()
    monkeypatch.setattr(by_solver.sandbox, "end", lambda: ended.append(len(asked)))

    def solved(tolerance):
        asked.append(tolerance)
        return replace(ours, cost=replace(ours.cost, peak_bytes=int(1e9 * tolerance)))

    found = by_solver._as_good_as_its_grid(solved, ours, -1.0)
    first, *tries = asked
    assert (first, len(tries), ended) == (max(tries), len(set(tries)), [0])
    assert found.cost.peak_bytes == int(1e9 * max(tries))


def test_solvers_that_are_asked_for_get_the_tolerance_of_the_study_and_their_own_settings():
    named = [f"{external_codes.__name__}:{name}" for name in ("known_peers", "installed_peers")]
    options = accuracy_cost.Options(methods=("bem", *named))
    solvers = dict.fromkeys(case[2] for case in accuracy_cost._singles(options) if case[0] == "others")
    told = [{n: v for n, v in solver.settings if n != "code"} for solver in solvers]
    assert told == [{"tolerance": accuracy_cost._TOLERANCE, "solver": name} for name in named]


def test_a_peer_that_fails_is_a_sentence():
    asked = peer(external_codes.THIS_CODE).but(settings=(("solver", "no_such_module:solve"),))
    with pytest.raises(NotConverged, match="no_such_module:solve: raised ModuleNotFoundError"):
        asked.do()


@pytest.mark.parametrize("code", [external_codes.THIS_CODE, "tamaas"])
def test_an_installed_peer_counts_the_area_that_is_counted_here(code):
    pytest.importorskip(code)
    solve = peer(code, seed=4178)
    found = solve.do()
    assert abs(float(found.pixel - found.pixel_bem)) < 0.1 * 0.103 * float(found.pixel) * 2
    # The same areas are read off its pressures as off ours.
    own = solve["problem"]
    pressed = bem.solve(own.heights((64, 64)), HalfSpace(solid=own.elastic), mean_pressure=own.pressure)
    exact = contact_areas(pressed.checked(), subcell=True)
    for name in ("perimeter", "subcell"):
        assert float(found[name]) == pytest.approx(getattr(exact, name), rel=0.02)
    # The interpreter and what it loads are not counted.
    assert 0 <= float(found.peak_bytes) < 2**26
