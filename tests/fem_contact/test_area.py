"""Counted, corrected and extrapolated contact areas."""

import numpy as np
import pytest

from fem_contact.area import EDGE_CONSTANTS, ContactAreas, contact_areas, limit_area
from fem_contact.contact import ContactResult, Cost, Residuals, Status
from fem_contact.errors import InvalidInput


def result_of(
    contact: np.ndarray, *, lengths: tuple[float, float] = (1.0, 1.0), weights: np.ndarray | None = None
) -> ContactResult:
    zero = np.zeros(contact.shape)
    return ContactResult(
        pressure=contact * 1.0,
        gap=zero,
        displacement=zero,
        in_contact=contact,
        at_bound=np.zeros_like(contact),
        heights=zero,
        lengths=lengths,
        contact_modulus=1.0,
        offset=0.0,
        mean_pressure=1.0,
        status=Status.CONVERGED,
        residuals=Residuals(penetration=0, tension=0, complementarity=0, load=0),
        cost=Cost(wall_seconds=0, cpu_seconds=0, iterations=0, unknowns=1, peak_bytes=0),
        weights=weights,
    )


def test_edges_are_counted_along_both_directions_per_nominal_area() -> None:
    contact = np.zeros((8, 10), dtype=bool)
    contact[2:5, 3:9] = True
    lengths = (4.0, 20.0)
    areas = contact_areas(result_of(contact, lengths=lengths), edge_constant=0.25)
    dx, dy = 0.5, 2.0
    assert areas.pixel == 18 / 80
    assert areas.edge_length == pytest.approx((2 * 3 * dx + 2 * 6 * dy) / 80)
    assert areas.edge_fraction == 18 / 80
    assert areas.perimeter == pytest.approx(18 / 80 - 0.25 * 18 / 80)


def test_edge_length_of_a_disc_is_four_over_pi_times_its_circumference() -> None:
    n, a = 800, 0.31
    x = np.arange(n) / n - 0.5 + 0.3 / n
    contact = np.hypot(x[:, None], x[None, :]) < a
    areas = contact_areas(result_of(contact))
    assert areas.edge_length == pytest.approx(4 / np.pi * 2 * np.pi * a, rel=5e-3)
    assert areas.edge_fraction == pytest.approx(areas.edge_length / n, rel=1e-12)


def test_edges_across_the_period_count() -> None:
    contact = np.zeros((6, 6), dtype=bool)
    contact[0] = True
    assert contact_areas(result_of(contact)).edge_length == pytest.approx(2.0)


def test_points_count_by_their_weight() -> None:
    contact = np.zeros((4, 4), dtype=bool)
    contact[0, 0] = True
    weights = np.full((4, 4), 14 / 15)
    weights[0, 0] = 2.0
    assert contact_areas(result_of(contact, weights=weights)).pixel == pytest.approx(2 / 16)


def areas_on(
    n: int, *, limit: float, constant: float, edge: float = 10.0, noise: float = 0.0
) -> ContactAreas:
    fraction = edge / n
    pixel = limit + constant * fraction + noise
    return ContactAreas(
        pixel=pixel,
        perimeter=pixel - 0.1 * fraction,
        edge_length=edge,
        edge_fraction=fraction,
        edge_constant=0.1,
        spacing=(1 / n, 1 / n),
    )


def test_limit_recovers_a_first_order_excess_on_uneven_grids() -> None:
    limit = limit_area([areas_on(n, limit=0.123, constant=0.09) for n in (32, 48, 81, 100)])
    assert limit.value == pytest.approx(0.123, abs=1e-12)
    assert limit.edge_constant == pytest.approx(0.09, abs=1e-10)
    assert limit.uncertainty < 1e-12
    assert limit.grids == 4


def test_limit_uncertainty_covers_the_scatter_of_the_grids() -> None:
    generator = np.random.default_rng(11)
    misses = []
    for _ in range(400):
        grids = (32, 45, 64, 90, 128, 181)
        noise = {n: 0.05 * np.sqrt(10 / n) / n * generator.standard_normal() for n in grids}
        limit = limit_area([areas_on(n, limit=0.2, constant=0.1, noise=noise[n]) for n in grids])
        misses.append((limit.value - 0.2) / limit.uncertainty)
    # Student's t with 4 degrees of freedom: 37 % lie beyond one standard error.
    assert 0.28 < np.mean(np.abs(misses) > 1) < 0.47


def test_limit_of_full_contact_is_one() -> None:
    limit = limit_area([areas_on(n, limit=1.0, constant=0.1, edge=0.0) for n in (32, 64, 128)])
    assert (limit.value, limit.uncertainty) == (1.0, 0.0)


def test_limit_needs_three_areas_and_two_spacings() -> None:
    one = areas_on(32, limit=0.1, constant=0.1)
    with pytest.raises(InvalidInput, match="three areas"):
        limit_area([one, areas_on(64, limit=0.1, constant=0.1)])
    with pytest.raises(InvalidInput, match="two spacings"):
        limit_area([one, one, one])


def test_constants_are_named_by_discretisation() -> None:
    assert set(EDGE_CONSTANTS) == {"bem", "fem"}
    with pytest.raises(TypeError):
        EDGE_CONSTANTS["bem"] = 1.0  # type: ignore[index]
