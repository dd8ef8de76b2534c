r"""Local minima of an elastic solid drawn to a hard wall by a law of the gap: projected Newton with FFTs.

The unknown is the gap itself, g >= 0. With u = g + h - offset and the stiffness K(q) = 1 / C(q),

.. math:: E(g) = \tfrac12\, (g + h)\cdot K (g + h) + \sum \phi(g) + p_0 \sum g ,\qquad g \ge 0

at a given mean pressure p0 (K leaves the mean out); at a given offset p0 is the multiplier of the mean gap.
The gradient is the force of the wall, p + tau(g), which is zero where g > 0 and not negative where g = 0. A
solid of hardness H yields where p reaches it: the wall gives way, g < 0 costs H |g|, and p = H there. At
g = 0 the energy then has a kink that a step may reach from either side and does not cross.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from fem_contact._types import Array, Lengths, Mask
from fem_contact.adhesion.laws import GapLaw
from fem_contact.complementarity.fourier import FourierOperator
from fem_contact.contact import Status
from fem_contact.response import GivenResponse, Response
from fem_contact.settings import Settings


class Landscape:
    """The energy of one surface, one solid and one law; what is held, a `Point` says.

    With a `hardness`, the largest pressure H [Pa], gaps may be negative.
    """

    def __init__(
        self,
        heights: Array,
        *,
        response: Response,
        lengths: Lengths,
        law: GapLaw,
        threads: int | None = None,
        hardness: float | Array | None = None,
    ) -> None:
        self.heights = heights
        self.law, self.hardness = law, hardness
        shape = (heights.shape[0], heights.shape[1])
        self.operator = FourierOperator(response, shape, lengths, threads=threads)
        compliance = self.operator.compliance.ravel()
        self.mean_compliance = float(compliance[0])
        shift = 1 / float(np.max(compliance[1:]))

        def softened(qx: Array, qy: Array) -> Array:
            # Inverse of K + s: finite at q = 0, close to C elsewhere.
            c = response.compliance(qx, qy)
            return np.where((qx == 0) & (qy == 0), np.maximum(c, 1 / shift), c / (1 + shift * c))

        soft = GivenResponse(contact_modulus=response.contact_modulus, function=softened)
        self.inverse = FourierOperator(soft, shape, lengths, threads=threads)
        self.mean_height = float(np.mean(heights))
        self.pairs = 0

    def stiff(self, field: Array) -> Array:
        """K applied to a field, its mean left out [Pa]."""
        out = np.empty(field.shape)
        self.operator.invert(field, out)
        self.pairs += 1
        return out

    def soften(self, field: Array) -> Array:
        """Apply the inverse of K + s [m]."""
        out = np.empty(field.shape)
        self.inverse.apply(field, out)
        self.pairs += 1
        return out

    def stored(self, gap: Array) -> Array:
        """Energy of the law, and of what has yielded, at every point [J/m^2]."""
        if self.hardness is None:
            return self.law.energy(gap)
        return self.law.energy(np.maximum(gap, 0.0)) - self.hardness * np.minimum(gap, 0.0)

    def slope(self, gap: Array, sunk: Mask | None) -> Array:
        """Slope of the attraction at every point, none where the solid yields [Pa/m]."""
        if sunk is None:
            return self.law.slope(gap)
        return np.where(sunk, 0.0, self.law.slope(np.maximum(gap, 0.0)))


@dataclass(frozen=True, kw_only=True)
class Point:
    """What is held: the mean pressure [Pa] or the offset [m], exactly one of them."""

    mean_pressure: float | None = None
    offset: float | None = None

    @property
    def held(self) -> float:
        """Its value."""
        value = self.mean_pressure if self.offset is None else self.offset
        assert value is not None
        return value

    def held_of(self, state: Minimum) -> float:
        """Return the same of a state."""
        return state.mean_pressure if self.offset is None else state.offset

    def at(self, value: float) -> Point:
        """Hold the same at another value."""
        return Point(mean_pressure=value) if self.offset is None else Point(offset=value)


@dataclass(frozen=True, kw_only=True, eq=False)
class Minimum:
    """A stationary point reached by descent."""

    # (nx, ny): g [m]; K u, the pressure less its mean [Pa].
    gap: Array
    force: Array
    # p0 [Pa], offset [m].
    mean_pressure: float
    offset: float
    energy: float  # Mean elastic and interaction energy per area [J/m^2], without the work of the load
    # Largest force left on a point that may move, over the strength of the law or the rms pressure,
    # whichever is larger.
    imbalance: float
    status: Status
    iterations: int
    fft_pairs: int

    @property
    def separated(self) -> bool:
        """Whether there is no equilibrium because the tension pulls the surfaces apart."""
        return self.status is Status.SEPARATED


class _State:
    """Gap, its forces, and the points free to move."""

    def __init__(self, land: Landscape, point: Point, gap: Array) -> None:
        self.land, self.point = land, point
        self.held = point.offset is not None and land.mean_compliance == 0
        # A body of finite thickness resists a uniform displacement; K without its mean does not know.
        self.base = 1 / land.mean_compliance if point.offset is not None and land.mean_compliance > 0 else 0.0
        self.target = 0.0 if point.offset is None else point.offset - land.mean_height
        # Points below the wall, or at it and about to sink; None where the wall is hard.
        self.sunk: Mask | None = None
        self.gap = gap.copy() if land.hardness is not None else self.projected(gap)
        self.force = land.stiff(self.gap + land.heights)
        self.update()

    def update(self) -> None:
        if self.land.hardness is not None:
            self._update_yielding(self.land.hardness)
            return
        law = self.land.law
        self.attraction = law.traction(self.gap)
        self.total = self.force + self.attraction
        open_ = self.gap > 0
        if self.held:
            count = np.count_nonzero(open_)
            load = -float(np.mean(self.total[open_])) if count else -float(self.total.min())
            # Points about to leave the wall take part in the multiplier.
            leaving = ~open_ & (self.total + load < 0)
            if count and leaving.any():
                load = -float(np.mean(self.total[open_ | leaving]))
            self.load = load
        elif self.base > 0:
            self.load = self.base * (float(np.mean(self.gap)) - self.target)
        else:
            assert self.point.mean_pressure is not None
            self.load = self.point.mean_pressure
        self.gradient = self.total + self.load
        self._judge(open_ | (self.gradient < 0))

    def _update_yielding(self, hardness: float | Array) -> None:
        """Take the forces and free points of a solid that yields [Pa], whose mean pressure is held."""
        assert self.point.mean_pressure is not None
        self.load = self.point.mean_pressure
        pressure = self.force + self.load
        at_wall = self.gap == 0
        self.sunk = (self.gap < 0) | (at_wall & (pressure > hardness))
        attraction = self.land.law.traction(np.maximum(self.gap, 0.0))
        self.attraction = np.where(self.sunk, -hardness, attraction)
        self.total = self.force + self.attraction
        self.gradient = self.total + self.load
        self._judge(~at_wall | self.sunk | (self.gradient < 0))

    def _judge(self, free: Mask) -> None:
        self.free = free
        self.rest = np.where(free, self.gradient, 0.0)
        # Weak adhesion is judged by the stresses of the contact, not by its own.
        scale = max(self.land.law.strength, float(np.sqrt(np.mean(self.force**2))))
        self.imbalance = float(np.max(np.abs(self.rest))) / scale

    @property
    def separated(self) -> bool:
        """Whether a tension pulls on surfaces that no longer attract each other enough to resist it."""
        tension = self.point.mean_pressure is not None and self.load < 0
        return tension and float(np.max(self.attraction)) < -self.load and not np.any(self.gap <= 0)

    def projected(self, gap: Array) -> Array:
        """Nearest gap that is allowed and, where the offset is held, has the mean that belongs to it."""
        if self.sunk is not None:
            return np.where(self.sunk, np.minimum(gap, 0.0), np.maximum(gap, 0.0))
        if not self.held:
            return np.maximum(gap, 0.0)
        shift = 0.0
        for _ in range(60):
            moved = np.maximum(gap + shift, 0.0)
            miss = self.target - float(np.mean(moved))
            share = np.count_nonzero(moved) / moved.size
            if share == 0:
                shift = self.target - float(gap.max())
                continue
            if abs(miss) <= 4e-16 * abs(self.target):
                break
            shift += miss / share
        return moved

    def hessian(self, curvature: Array, field: Array) -> Array:
        """H field on the free points; the mean is held where the offset is."""
        out = self.land.stiff(field)
        out += curvature * field
        if self.base > 0:
            out += self.base * float(np.mean(field))
        return self.restricted(out)

    def restricted(self, field: Array) -> Array:
        out = np.where(self.free, field, 0.0)
        if self.held:
            count = np.count_nonzero(self.free)
            out[self.free] -= float(np.sum(out)) / count
        return out


def descend(land: Landscape, point: Point, start: Array, *, settings: Settings) -> Minimum:
    """Follow the energy downhill from a gap [m], projected on what is allowed, to a local minimum.

    The settings say the largest `imbalance` that will do, and what Newton steps and time are allowed.
    """
    before, clock = land.pairs, time.monotonic()
    state = _State(land, point, start)
    status, iteration = Status.ITERATION_LIMIT, 0
    slow = 0
    while True:
        if state.imbalance <= settings.tolerance:
            status = Status.CONVERGED
            break
        if state.separated:
            status = Status.SEPARATED
            break
        if iteration == settings.max_iterations:
            break
        if settings.expired(clock):
            status = Status.TIME_LIMIT
            break
        iteration += 1
        moved = _search(state, _newton_direction(state))
        if not moved:
            moved = _search(state, -state.restricted(state.rest) / land.operator.stiffness)
            slow += 1
        if not moved or slow > 20:
            status = Status.STAGNATED
            break
    offset, field = point.offset, state.gap + land.heights
    if offset is None:
        offset = float(np.mean(state.gap)) + land.mean_height - land.mean_compliance * state.load
    elastic = 0.5 * (float(np.mean(state.force * field)) + land.mean_compliance * state.load**2)
    return Minimum(
        gap=state.gap,
        force=state.force,
        mean_pressure=state.load,
        offset=offset,
        energy=elastic + float(np.mean(land.stored(state.gap))),
        imbalance=state.imbalance,
        status=status,
        iterations=iteration,
        fft_pairs=land.pairs - before,
    )


def _newton_direction(state: _State) -> Array:
    """Conjugate gradients on the Newton system, stopped where the energy curves down."""
    land = state.land
    curvature = land.slope(state.gap, state.sunk)
    residual = -state.restricted(state.rest)
    goal = min(0.1, np.sqrt(state.imbalance)) * float(np.linalg.norm(residual))
    step = np.zeros_like(residual)
    image = state.restricted(land.soften(residual))
    direction = image.copy()
    product = float(np.sum(residual * image))
    for _ in range(_INNER):
        bent = state.hessian(curvature, direction)
        bend = float(np.sum(direction * bent))
        if bend <= 0:
            # Downhill and curving down: as far as a step may go, the line search decides.
            return step + _farthest(state, direction) * direction
        length = product / bend
        step += length * direction
        residual -= length * bent
        if float(np.linalg.norm(residual)) <= goal:
            break
        image = state.restricted(land.soften(residual))
        product, previous = float(np.sum(residual * image)), product
        direction = image + product / previous * direction
    return step


def _farthest(state: _State, direction: Array) -> float:
    """Factor of a direction that moves no point by more than it may, those out of reach excepted."""
    reach = state.land.law.reach
    # Nearest point first: surfaces far apart may come as close as that point is.
    allowed = _FARTHEST * reach + np.maximum(state.gap - 4 * reach, 0.0)
    if state.sunk is not None:
        # Below the wall nothing attracts, and the energy is quadratic.
        allowed[state.sunk] = np.inf
    fastest = float(np.max(np.abs(direction) / allowed))
    return 1 / fastest if fastest > 0 else 1.0


#: Conjugate-gradient steps per Newton step; ranges of the law by which a point within reach may move in one.
_INNER, _FARTHEST = 100, 2.0


def _search(state: _State, direction: Array) -> bool:
    """Move the state along the projected direction until its energy falls; False where it never does."""
    land = state.land
    if not np.any(direction):
        return False
    factor = min(1.0, _farthest(state, direction))
    energy = land.stored(state.gap)
    floor = 1e-15 * float(np.sum(np.abs(energy)))
    for _ in range(30):
        gap = state.projected(state.gap + factor * direction)
        change = gap - state.gap
        force = land.stiff(change)
        slope = float(np.sum(state.gradient * change))
        # The energy there less that here, summed over the points, but without the cancellation of two
        # energies: the attraction's part of the gradient is replaced by its own rise.
        rise = slope - float(np.sum(state.attraction * change)) + 0.5 * float(np.sum(change * force))
        rise += 0.5 * state.base * float(np.mean(change)) ** 2 * change.size
        rise += float(np.sum(land.stored(gap) - energy))
        if rise <= 1e-4 * slope + floor and slope < 0:
            state.gap = gap
            state.force = state.force + force
            state.update()
            return True
        factor *= 0.5
    return False


def least_curvature(land: Landscape, point: Point, gap: Array) -> tuple[float, float]:
    """Smallest curvature of the energy over the points free to move, and its uncertainty.

    The least Ritz value of Lanczos's method in the metric of K + s, and the bound on its distance to an
    eigenvalue. Positive: a minimum; its sign does not depend on the metric. Infinite where no point is free.
    """
    state = _State(land, point, gap)
    if np.count_nonzero(state.free) <= (1 if state.held else 0):
        return np.inf, 0.0
    curvature = land.slope(state.gap, state.sunk)
    rng = np.random.default_rng(7)
    v = state.restricted(rng.standard_normal(gap.shape))
    image = state.restricted(land.soften(v))
    norm = float(np.sqrt(np.sum(v * image)))
    old = np.zeros_like(v)
    beta, alphas, betas = 0.0, [], []
    value = uncertainty = np.inf
    for _ in range(_LANCZOS):
        v, image = v / norm, image / norm
        bent = state.hessian(curvature, image) - beta * old
        alpha = float(np.sum(bent * image))
        alphas.append(alpha)
        old, v = v, state.restricted(bent - alpha * v)
        image = state.restricted(land.soften(v))
        beta = norm = float(np.sqrt(max(float(np.sum(v * image)), 0.0)))
        betas.append(beta)
        matrix = np.diag(alphas) + np.diag(betas[:-1], 1) + np.diag(betas[:-1], -1)
        values, vectors = np.linalg.eigh(matrix)
        value, uncertainty = float(values[0]), float(beta * abs(vectors[-1, 0]))
        # Beyond this the vectors are no longer orthogonal and curvatures of nothing appear.
        if uncertainty <= _SETTLED * float(np.max(np.abs(values))):
            break
    return value, max(uncertainty, _SETTLED * float(np.max(np.abs(values))))


#: Steps of Lanczos's method, and the relative uncertainty at which the least curvature counts as found.
_LANCZOS, _SETTLED = 80, 1e-6
