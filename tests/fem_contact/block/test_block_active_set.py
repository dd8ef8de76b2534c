from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fem_contact import HeightField, Solid, Status
from fem_contact.block import plan_mesh, solve
from fem_contact.block.full import active_set
from fem_contact.block.full.active_set import solve_contact
from fem_contact.block.full.block import Block
from fem_contact.block.full.linear import LinearSolution
from fem_contact.block.full.multigrid import build_hierarchy
from fem_contact.block.full.system import highest_nodes

LIMITS = {"tolerance": 1e-9, "max_iterations": 30}


def bumpy_block():
    mesh = plan_mesh((4, 4), (1.0, 1.0))
    heights = -np.random.default_rng(21).random((4, 4))
    return Block(hierarchy=build_hierarchy(mesh, poisson=0.3), heights=heights)


@pytest.mark.parametrize("offset", [-0.4, -0.2, 0.0, 0.3])
def test_an_offset_starts_from_the_points_it_reaches_and_at_least_from_the_highest(offset):
    heights = -np.arange(12.0).reshape(3, 4) / 10
    problem = SimpleNamespace(offset=offset)
    assert highest_nodes(heights, problem).sum() == max(1, np.sum(heights >= offset))


class _Flipping:
    """A linear problem whose answer always asks for the opposite set."""

    class preconditioner:  # noqa: N801
        nbytes = 0

    def __init__(self, block, nodes):
        self.nodes = nodes

    def advance(self, state, **settings):
        solution = LinearSolution(x=np.zeros(1), relative_residual=0.0, iterations=1, converged=True)
        return replace(state, following=~self.nodes), solution


@pytest.mark.parametrize(("violation", "status"), [(1.0, Status.CYCLING), (1e-12, Status.CONVERGED)])
def test_a_set_that_returns_is_a_cycle_unless_nothing_is_violated(monkeypatch, violation, status):
    monkeypatch.setattr(active_set, "_SetProblem", _Flipping)
    start = np.zeros((4, 4), dtype=bool)
    start[0] = True
    asked = {"load": 0.1, "offset": 0.0, "start": start, "violation": lambda *_: violation}
    found = solve_contact(bumpy_block(), **asked, **LIMITS)
    assert found.status is status
    assert found.iterations < 6


def test_linear_systems_that_do_not_converge_are_reported(monkeypatch):
    monkeypatch.setattr(active_set, "_LINEAR_STEPS", 2)
    x = np.arange(8) / 8
    heights = 1e-3 * np.cos(2 * np.pi * x)[:, None] * np.cos(2 * np.pi * x)
    surface = HeightField(heights=heights, lengths=(1.0, 1.0))
    contact = solve(surface, Solid(young=1.0, poisson=0.3), mean_pressure=1e-3, method="full").contact
    assert contact.status is Status.ITERATION_LIMIT
    assert "linear residual" in contact.provenance["tolerance"]


def test_updated_set_is_contact_under_pressure_and_penetrating_nodes():
    block, asked = bumpy_block(), {"load": 0.05, "offset": 0.0, "violation": lambda *_: 1.0}
    asked["start"] = np.ones((4, 4), dtype=bool)
    first = solve_contact(block, **asked, **(LIMITS | {"max_iterations": 1}))
    assert first.status is Status.ITERATION_LIMIT
    assert first.force.sum() == pytest.approx(0.05, rel=1e-2)
    assert first.force.min() < 0
    last = solve_contact(block, **asked, **LIMITS)
    assert last.status is Status.CONVERGED
    assert last.force[last.in_contact].min() > 0
    assert last.gap[~last.in_contact].min() >= 0
    assert last.force.sum() == pytest.approx(0.05, rel=1e-8)
