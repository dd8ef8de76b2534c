import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from surfaces import SOFT, rough_surface

from fem_contact import BondedLayer, InvalidInput, NotConverged, Solid, Status, adhesion, bem
from fem_contact.adhesion import path as adhesion_path
from fem_contact.adhesion.descent import Landscape, Point, descend, least_curvature
from fem_contact.adhesion.laws import Dugdale, Exponential
from fem_contact.settings import Settings
from fem_contact.surface import HeightField


def rough(points=48, seed=11, gradient=0.1, *, waves=6):
    """A surface of wavelengths 1/2 to 1/waves of the period."""
    return rough_surface((points, points), seed=seed, waves=waves, longest=1.9, gradient=gradient)


def sticky_tips(points=64, *, seed=11):
    """Four blunt tips of slightly different height, with a law of Tabor parameter about 2 at each."""
    x = np.arange(points) / points
    heights = 0.0025 * (np.cos(4 * np.pi * x)[:, None] + np.cos(4 * np.pi * x)[None, :])
    heights = heights + rough(points, seed, 0.004, waves=5).heights
    surface = HeightField(heights=heights, lengths=(1.0, 1.0))
    return surface, law_for(points, work=6e-4)


def law_for(points, *, work=1e-4, cells=2.5, kind=Exponential):
    """A law whose length E* w / sigma^2 spans some cells of a grid of period 1."""
    return kind(work=work, reach=np.sqrt(cells / points * work))


def test_uniform_layer_snaps_exactly_where_a_spring_with_that_law_does():
    # One degree of freedom: (offset - g) / C0 = tau(g). It is unstable at tau' = -1 / C0, where
    # g = rho ln(w C0 / rho^2) and offset = g + rho; the wall lets go at tau(0) C0 = offset.
    layer = BondedLayer(solid=Solid(young=1.0, poisson=0.0), thickness=1.0)
    c0 = float(layer.compliance(np.zeros(1), np.zeros(1))[0])
    rho = 0.02
    law = Exponential(work=5 * rho**2 / c0, reach=rho)
    flat = HeightField(heights=np.zeros((8, 6)), lengths=(0.05, 0.05))
    offsets = np.concatenate([np.arange(10, -1, -0.5), np.arange(-1, 10, 0.5)]) * rho
    path = adhesion_path.follow(flat, layer, law=law, offsets=offsets, tolerance=1e-9, threads=1)
    snap, part = path.jumps
    assert (snap.kind, part.kind) == ("snap-in", "pull-off")
    assert snap.after.offset / rho < np.log(5) + 1 < snap.before.offset / rho
    assert part.before.offset / rho <= 5 * (1 + 1e-9) < part.after.offset / rho
    # Energy lost at the wall's release: the branch g = 0 against the open one at the same offset.
    o = part.after.offset
    g = part.after.mean_gap
    lost = 0.5 * o**2 / c0 - law.work - (0.5 * (o - g) ** 2 / c0 - law.work * np.exp(-g / rho))
    assert part.dissipated == pytest.approx(lost, rel=2e-3)


def wavy(points, alpha):
    """A wave with Johnson's (1995) adhesion parameter alpha, and its pressure scale p* = pi E* Delta / L."""
    amplitude = 0.01
    scale = np.pi * amplitude
    work = alpha**2 * scale**2 / 2
    x = np.arange(points) / points
    heights = np.repeat(amplitude * np.cos(2 * np.pi * x)[:, None], 2, axis=1)
    surface = HeightField(heights=heights, lengths=(1.0, 2.0 / points))
    return surface, Exponential(work=work, reach=np.sqrt(2.1 / points * work)), scale


def johnson(psi, alpha):
    """Mean pressure over p* where the contact covers the share 2 psi / pi of the wave (Johnson 1995)."""
    return np.sin(psi) ** 2 - alpha * np.sqrt(np.tan(psi))


def test_wavy_surface_snaps_to_full_contact_and_pulls_off_where_johnson_says():
    alpha = 0.3
    surface, law, scale = wavy(512, alpha)
    top = minimize_scalar(lambda s: -johnson(s, alpha), bounds=(0.8, 1.5), method="bounded")
    low = minimize_scalar(lambda s: johnson(s, alpha), bounds=(0.01, 0.8), method="bounded")
    loads = np.arange(0, 0.5, 0.05) * scale
    up = adhesion_path.follow(surface, SOFT, law=law, mean_pressures=loads, threads=1)
    (snap,) = up.jumps
    assert snap.kind == "snap-in"
    assert snap.before.mean_pressure / scale == pytest.approx(-top.fun, rel=0.02)
    assert snap.after is not None
    assert snap.after.contact == 1.0
    loads = np.concatenate([np.arange(0, 0.2, 0.05), np.arange(0.1, -0.2, -0.02)]) * scale
    down = adhesion_path.follow(surface, SOFT, law=law, mean_pressures=loads, threads=1)
    assert down.greatest_tension / scale == pytest.approx(-low.fun, rel=0.03)


@pytest.mark.parametrize("points", [128, 512])
def test_contact_of_a_wavy_surface_is_johnsons_within_its_process_zone(points):
    alpha, reduced = 0.3, 0.15
    psi = np.linspace(0.3, 1.0, 4000)
    width = 2 / np.pi * np.interp(reduced, johnson(psi, alpha), psi)
    surface, law, scale = wavy(points, alpha)
    state = adhesion.solve(surface, SOFT, law=law, mean_pressure=reduced * scale, threads=1).checked()
    # At both edges the wall ends somewhere in the process zone, (pi / 4) 2.1 dx, and on a whole cell.
    assert np.mean(state.contact.in_contact) == pytest.approx(width, abs=2 * (np.pi / 4 * 2.1 + 1) / points)


@pytest.mark.parametrize("kind", [Exponential, Dugdale])
def test_what_is_returned_is_a_minimum(kind):
    surface = rough()
    law = law_for(48, kind=kind, cells=3.0)
    state = adhesion.solve(surface, SOFT, law=law, mean_pressure=0.01, threads=1).checked()
    assert state.imbalance < 1e-6
    assert state.contact.residuals.worst < 1e-5
    land = Landscape(surface.heights, response=SOFT, lengths=surface.lengths, law=state.law, threads=1)
    gap, load = state.contact.gap, state.contact.mean_pressure

    def energy(gap):
        shape = gap + land.heights
        return float(np.mean(0.5 * land.stiff(shape) * shape + land.stored(gap)))

    least = energy(gap) + load * float(np.mean(gap))
    assert energy(gap) == pytest.approx(state.energy, rel=1e-10)
    rng = np.random.default_rng(23)
    for size in (1e-3, 1e-2, 1e-1):
        for _ in range(6):
            noise = rng.standard_normal(gap.shape)
            noise = np.real(np.fft.ifft2(np.fft.fft2(noise) * (rng.random(gap.shape) < 0.3)))
            other = np.maximum(gap + size * law.reach * noise, 0)
            assert energy(other) + load * float(np.mean(other)) > least
    curved = adhesion.stability(state, SOFT)
    assert curved.is_minimum


def test_least_curvature_has_the_sign_and_size_of_the_dense_eigenvalue():
    surface = rough(12, waves=4)
    law = law_for(12, work=3e-4)
    land = Landscape(surface.heights, response=SOFT, lengths=(1.0, 1.0), law=law, threads=1)
    point = Point(mean_pressure=0.002)
    gap = float(surface.heights.max()) - surface.heights
    found = descend(land, point, gap, settings=Settings(tolerance=1e-6))
    assert found.status is Status.CONVERGED
    gap = found.gap
    free = np.flatnonzero(gap > 0)
    dense, metric = np.empty((free.size, free.size)), np.empty((free.size, free.size))
    for column, place in enumerate(free):
        unit = np.zeros(gap.size)
        unit[place] = 1
        unit = unit.reshape(gap.shape)
        dense[:, column] = (land.stiff(unit) + law.slope(gap) * unit).ravel()[free]
        metric[:, column] = land.soften(unit).ravel()[free]
    exact = np.linalg.eigvals(metric @ dense).real.min()
    value, uncertainty = least_curvature(land, point, gap)
    assert value == pytest.approx(exact, abs=max(uncertainty, 1e-8))


def test_curvature_falls_to_zero_where_the_surfaces_snap():
    surface, law = sticky_tips()
    top = float(surface.heights.max())
    offsets = np.arange(top + 6 * law.reach, top, -law.reach / 2)
    path = adhesion_path.follow(surface, SOFT, law=law, offsets=offsets, threads=1)
    snap = path.jumps[0]
    near = adhesion.solve(surface, SOFT, law=law, offset=snap.before.offset, threads=1).checked()
    away = adhesion.solve(surface, SOFT, law=law, offset=snap.before.offset + law.reach, threads=1).checked()
    far_curvature = adhesion.stability(away, SOFT)
    near_curvature = adhesion.stability(near, SOFT)
    assert near_curvature.is_minimum
    assert near_curvature.curvature < 0.3 * far_curvature.curvature


def test_vanishing_adhesion_recovers_the_elastic_contact():
    surface = rough()
    elastic = bem.solve(surface, SOFT, mean_pressure=0.01, threads=1).checked()
    differences = []
    for work in (1e-9, 1e-10):
        law, asked = Exponential(work=work, reach=1e-3), {"mean_pressure": 0.01, "tolerance": 1e-4}
        state = adhesion.solve(surface, SOFT, law=law, **asked, threads=1).checked()
        differences.append(np.linalg.norm(state.contact.pressure - elastic.pressure))
        assert state.contact.offset == pytest.approx(elastic.offset, rel=1e-4)
    assert differences[0] < 1e-3 * np.linalg.norm(elastic.pressure)
    assert differences[1] < 0.2 * differences[0]


def test_a_grid_that_does_not_resolve_the_process_zone_is_refused_with_the_grid_that_does():
    surface = rough(32, waves=4)
    law = law_for(32, cells=0.8)
    with pytest.raises(InvalidInput, match=r"spans 0\.8 cells.*use 80 x 80 points"):
        adhesion.solve(surface, SOFT, law=law, mean_pressure=0.01)
    adhesion.solve(surface.resampled((80, 80)), SOFT, law=law, mean_pressure=0.01, threads=1).checked()


def test_the_offset_of_a_given_pressure_gives_that_pressure_back():
    surface = rough(32, waves=4)
    law = law_for(32, cells=3.0)
    one = adhesion.solve(surface, SOFT, law=law, mean_pressure=0.01, threads=1).checked()
    again = {"offset": one.contact.offset, "start": one.contact.gap}
    two = adhesion.solve(surface, SOFT, law=law, **again, threads=1).checked()
    assert two.contact.mean_pressure == pytest.approx(0.01, rel=1e-5)
    np.testing.assert_allclose(two.contact.gap, one.contact.gap, atol=1e-4 * law.reach)


def test_a_limit_on_iterations_or_time_is_a_status():
    surface = rough(32, waves=4)
    law = law_for(32)
    state = adhesion.solve(surface, SOFT, law=law, mean_pressure=0.01, max_iterations=1, threads=1)
    assert state.contact.status is Status.ITERATION_LIMIT
    state = adhesion.solve(surface, SOFT, law=law, mean_pressure=0.01, time_limit=1e-9, threads=1)
    assert state.contact.status is Status.TIME_LIMIT
    with pytest.raises(NotConverged, match="iteration limit"):
        adhesion_path.follow(surface, SOFT, law=law, mean_pressures=[0.01], max_iterations=1, threads=1)


def test_an_offset_of_zero_is_taken_though_the_mean_height_is_zero_but_for_rounding():
    heights = np.full((32, 32), 2.0**-7)
    heights[::2] *= -1
    heights[1, 0] *= 1 + 2.0**-51
    assert 0 < heights.mean() < 1e-20
    surface = HeightField(heights=heights, lengths=(1.0, 1.0))
    with pytest.raises(InvalidInput, match="start"):  # the next thing to be looked at
        adhesion.solve(surface, SOFT, law=law_for(32), offset=0.0, start=np.zeros((3, 3)))


def weak(share, *, points=64, kind=Exponential):
    """Adhesion of this share of the energy of full contact, on a rough surface under load."""
    surface = rough(points, seed=13)
    work = share * surface.spectral_sum(lambda q: SOFT.contact_modulus * q / 4)
    law = kind(work=work, reach=float(np.sqrt(4 / points * work / SOFT.contact_modulus)))
    return surface, law, 0.05 * SOFT.contact_modulus * surface.rms_gradient


@pytest.mark.parametrize("share", [1e-6, 1e-4, 1e-2])
def test_weak_adhesion_takes_tens_of_transforms(share):
    surface, law, load = weak(share)
    state = adhesion.solve(surface, SOFT, law=law, mean_pressure=load).checked()
    # From first touch 200 to 3000 pairs, or no convergence at all.
    assert state.contact.cost.fft_pairs < 120
    plain = bem.solve(surface, SOFT, mean_pressure=load)
    assert state.contact.in_contact.mean() >= plain.in_contact.mean()


@pytest.mark.parametrize("kind", [Exponential, Dugdale])
@pytest.mark.parametrize("share", [1e-3, 0.029])
def test_weak_adhesion_started_from_the_plain_contact_is_on_the_approaching_branch(share, kind):
    surface, law, load = weak(share, points=48, kind=kind)
    short = adhesion.solve(surface, SOFT, law=law, mean_pressure=load).checked()
    touch = surface.heights.max() - surface.heights
    long = adhesion.solve(surface, SOFT, law=law, mean_pressure=load, start=touch).checked()
    np.testing.assert_array_equal(short.contact.in_contact, long.contact.in_contact)
    assert short.energy == pytest.approx(long.energy, rel=1e-5)
    assert short.contact.cost.fft_pairs < long.contact.cost.fft_pairs


def test_weak_adhesion_of_a_yielding_solid_starts_from_the_yielded_contact():
    surface, law, load = weak(1e-3)
    state = adhesion.solve(surface, SOFT, law=law, mean_pressure=load, hardness=8 * load).checked()
    assert state.contact.at_bound.any()
    assert state.contact.cost.fft_pairs < 150
