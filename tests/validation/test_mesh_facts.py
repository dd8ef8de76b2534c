from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from fem_contact.block import wave_errors
from validation.comparison import explain as effects


@dataclass
class _Surface:
    length: tuple[float, float] = (1e-5, 1e-5)
    lambda_short: float = 1.25e-6
    lambda_long: float = 5e-6


def scene_of(fem: object) -> SimpleNamespace:
    return SimpleNamespace(
        surface=_Surface(), solid=SimpleNamespace(poisson=0.3), methods=SimpleNamespace(fem=fem)
    )


@pytest.mark.parametrize("growth", [1.2, 2.0])
def test_explanation_states_the_error_of_every_finite_element_grid(monkeypatch, growth):
    monkeypatch.setattr(effects, "shortest_wavelength", lambda surface: surface.lambda_short)
    fem = SimpleNamespace(grids=[(64, 64), (32, 32)], depth=None, growth=growth)
    facts = dict(effects._mesh_facts(scene_of(fem)))
    assert list(facts) == ["finite elements, 32 x 32", "finite elements, 64 x 64"]
    for n in (32, 64):
        short, long = wave_errors((n, n), (1e-5, 1e-5), [1.25e-6, 5e-6], poisson=0.3, growth=growth)
        words = facts[f"finite elements, {n} x {n}"]
        for error in (short.along_axis, short.along_diagonal, long.along_axis):
            assert f"{error:+.2%}" in words


def test_scene_without_finite_elements_states_none():
    assert list(effects._mesh_facts(scene_of(None))) == []
