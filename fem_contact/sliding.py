r"""Steady sliding of a rigid rough surface on a viscoelastic half-space, without friction in the interface.

Seen from the surface, which moves with velocity v along x, nothing changes in time: a wave of pressure with
wavevector q passes the solid's points with the frequency omega = -q_x v, and

.. math:: \hat u(\mathbf q) = C(\mathbf q)\, \hat p(\mathbf q),\qquad
          C(\mathbf q) = \frac{2}{|\mathbf q|\, E^*(-q_x v)},\qquad p \ge 0,\ g \ge 0,\ p g = 0

The response is not symmetric, so there is no energy to minimise. It is monotone, since a solid that
dissipates has Re C > 0: the solution is unique, and the splitting of Peaceman and Rachford finds it.
"""

import math
import time
from collections import deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.fft

from fem_contact import bem
from fem_contact._checks import finite, instance, positive, pressures
from fem_contact._types import Array, Complex
from fem_contact.contact import Clock, ContactResult, HasContact, Status
from fem_contact.errors import InvalidInput
from fem_contact.settings import Settings, inner_tolerance
from fem_contact.surface import HeightField
from fem_contact.surface.heights import wavevectors
from fem_contact.viscoelastic import ViscoelasticSolid, check_viscoelastic

#: Steps that the acceleration remembers.
_MEMORY = 5
#: Tolerance of the elastic contact inside a step over the residual of the step.
_INNER = 1e-1
#: It needs not be met closer than this share of the tolerance of the whole.
_INNER_FLOOR = 0.1
#: FFT pairs of a step besides the elastic contact.
_PAIRS = 2.5
#: Steps without a smaller residual after which it no longer falls.
_PATIENCE = 60


@dataclass(frozen=True, kw_only=True, eq=False)
class SlidingContact(HasContact):
    r"""A contact that slides steadily, and what resists it.

    Attributes
    ----------
    contact : ContactResult
        Pressure, gap and displacement, as seen from the rigid surface. Its `contact_modulus` is that of the
        relaxed solid, E_0 / (1 - nu^2); its iterations are steps of the splitting, its linear iterations the
        conjugate-gradient steps inside them.
    velocity : float
        v [m/s], along +x if positive.
    friction : float
        mu, the force that resists the motion over the load: `dissipation`, and half of what `slopes` say
        otherwise times the loss angle of the waves at work. Where it is fast, and these are nearly glassy,
        that is the dissipation.
    friction_interval : tuple of float
        It on 95 % of grids: half of the losses in waves of less than four points, and twice what was added to
        `dissipation`, to both sides (held that of 32 points per shortest wave from 4 to 16 on 95 to 100 %).
    slopes : float
        -<p h_x>/p0, by the slopes of the rigid surface.
    dissipation : float
        The power that the solid turns into heat over p0 v,
        :math:`\sum_q q_x \operatorname{Im} C\, |\hat p|^2 / p_0`. On one grid it differs from `slopes` by the
        slope of the gap at the edges of the contact, which the grid does not resolve: little of the losses
        where |C| is in phase, but as much of the slopes.
    contraction : float
        Factor in [0, 1) by which each step shrinks the error at least, tan(phi/2) of the largest loss angle
        phi on this grid; the acceleration does better.
    """

    contact: ContactResult
    velocity: float
    friction: float
    friction_interval: tuple[float, float]
    slopes: float
    dissipation: float
    contraction: float


def slide(
    surface: HeightField,
    solid: ViscoelasticSolid,
    *,
    velocity: float,
    mean_pressure: float,
    tolerance: float = 1e-8,
    max_iterations: int = 500,
    start: Array | None = None,
    time_limit: float | None = None,
    threads: int | None = None,
) -> SlidingContact:
    r"""Press a rigid rough surface against a viscoelastic half-space and let it slide steadily along x.

    Parameters
    ----------
    surface : HeightField
        The rigid body, periodic; what a period leaves behind meets the next one.
    solid : ViscoelasticSolid
        Such as `PronySolid` or `TabulatedSolid`.
    velocity : float
        v [m/s] of the surface along x, of either sign; 0 is the relaxed solid at rest.
    mean_pressure : float
        Nominal pressure p0 [Pa], positive.
    tolerance : float
        As of `bem.solve`: sum p |g| <= tolerance h_rms sum p, penetration at most ten times as much.
    max_iterations : int
        Steps of the splitting allowed; each solves one elastic contact from the one before.
    start : (nx, ny) array, optional
        Pressure [Pa] to start from, for instance that of the velocity before.
    time_limit : float, optional
        Seconds allowed.
    threads : int, optional
        All available processors if not given.

    Returns
    -------
    SlidingContact
        Use `.checked()` before relying on it: the residuals are those of the viscoelastic response, computed
        afresh.

    Raises
    ------
    InvalidInput
        For a pressure that is not positive, a start of the wrong shape or sign, or a solid whose storage
        modulus is not positive or whose loss modulus is negative at a frequency of this grid.

    Notes
    -----
    D. W. Peaceman, H. H. Rachford, J. Soc. Ind. Appl. Math. 3, 28 (1955); P. L. Lions, B. Mercier, SIAM J.
    Numer. Anal. 16, 964 (1979). With the elastic response G = |C| as the metric, a step is an elastic contact
    on G and a division per wavevector, and the error shrinks by tan(phi/2) with tan phi the largest loss
    factor: by .52 for E_inf/E_0 = 10, by .94 for 1000. Steps are accelerated after D. G. Anderson, J. ACM 12,
    547 (1965); one that does not shorten the next is taken back, and the plain step taken.

    Examples
    --------
    >>> x = np.arange(32) / 32
    >>> wave = HeightField(heights=1e-3 * np.cos(2 * np.pi * x)[:, None] * np.ones(4), lengths=(1.0, 0.125))
    >>> from fem_contact import PronySolid
    >>> rubber = PronySolid(relaxed=1.0, moduli=(9.0,), times=(1.0,), poisson=0.0)
    >>> slow = slide(wave, rubber, velocity=1e-3, mean_pressure=1e-3).checked()
    >>> fast = slide(wave, rubber, velocity=0.3, mean_pressure=1e-3).checked()
    >>> bool(0 < slow.friction < fast.friction)
    True
    """
    settings = Settings(
        tolerance=tolerance, max_iterations=max_iterations, time_limit=time_limit, threads=threads
    )
    problem = _Problem(surface, solid, velocity=velocity, mean_pressure=mean_pressure, settings=settings)
    first = None if start is None else pressures("start", start, surface.shape)
    return _iterated(problem, first)


@dataclass(frozen=True, kw_only=True)
class _Magnitude:
    """The elastic response |C|, which the splitting measures errors with."""

    solid: ViscoelasticSolid
    velocity: float
    contact_modulus: float

    def compliance(self, qx: Array, qy: Array) -> Array:
        """|C| [m/Pa], 0 at q = 0."""
        return np.abs(_compliance(self.solid, qx, qy, velocity=self.velocity))


def _compliance(solid: ViscoelasticSolid, qx: Array, qy: Array, *, velocity: float) -> Complex:
    """C [m/Pa] at wavevectors of shapes (nx, 1) and (1, ny); 0 at q = 0."""
    passing = qx * velocity
    modulus = np.asarray(solid.modulus(np.abs(passing)))
    if modulus.shape != qx.shape or not (
        np.all(np.isfinite(modulus)) and modulus.real.min() > 0 and modulus.imag.min() >= 0
    ):
        raise InvalidInput(
            "solid.modulus: must give one finite E in Pa for each frequency, E' positive and E'' not negative"
        )
    inverse = (1 - solid.poisson**2) / modulus
    # Strains go like exp(i omega t) with omega = -q_x v: the conjugate where q_x v is positive.
    inverse = np.where(passing > 0, inverse.conj(), inverse)
    q = np.hypot(qx, qy)
    return np.where(q > 0, 2 * inverse / np.where(q > 0, q, 1.0), 0.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class _State:
    """An elastic contact of the splitting, judged by the viscoelastic response."""

    contact: ContactResult
    step: Array
    size: float


class _Problem:
    """Surface, solid, velocity and load, checked, with the response per wavevector."""

    def __init__(
        self,
        surface: HeightField,
        solid: ViscoelasticSolid,
        *,
        velocity: float,
        mean_pressure: float,
        settings: Settings,
    ) -> None:
        self.clock = Clock()
        instance("surface", surface, HeightField)
        check_viscoelastic(solid)
        finite("velocity", velocity)
        qx, qy = np.ix_(*wavevectors(surface.shape, surface.lengths))
        self.response = _compliance(solid, qx, qy, velocity=velocity)
        middle, odd = divmod(surface.shape[0], 2)
        if not odd:
            # The shortest wave along x runs both ways at once.
            self.response[middle] = self.response[middle].real
        relaxed = float(np.real(solid.modulus(np.zeros(1))[0])) / (1 - solid.poisson**2)
        self.metric = _Magnitude(solid=solid, velocity=velocity, contact_modulus=relaxed)
        self.magnitude = self.metric.compliance(qx, qy)
        self.level = float(np.mean(surface.heights))
        self.heights = surface.heights - self.level
        self.load = positive("mean_pressure", mean_pressure)
        self.surface, self.settings, self.qx = surface, settings, qx

    def forward(self, values: Array) -> Complex:
        """Fourier coefficients on half of the wavevectors."""
        return scipy.fft.rfft2(values, norm="forward", workers=self.settings.workers)

    def backward(self, spectrum: Complex) -> Array:
        """Values at the grid points."""
        shape, threads = self.surface.shape, self.settings.workers
        return scipy.fft.irfft2(spectrum, s=shape, norm="forward", workers=threads)

    def first(self, pressure: Array | None) -> Array:
        """Heights [m] that the first step presses on |C|: those whose gap has a given pressure."""
        if pressure is None:
            return self.heights
        return self.heights + self.backward((self.magnitude - self.response) * self.forward(pressure))

    def pressed(self, heights: Array, *, start: Array | None, tolerance: float, settings: Settings) -> _State:
        """Press heights on |C|, and see what the viscoelastic response makes of the pressure."""
        surface = HeightField(heights=heights, lengths=self.surface.lengths)
        contact = bem.solve(
            surface,
            self.metric,
            mean_pressure=self.load,
            start=start,
            tolerance=inner_tolerance(tolerance, of=self.surface.rms_height, on=surface.rms_height),
            time_limit=settings.time_limit,
            threads=settings.threads,
        )
        pressure = self.forward(contact.pressure)
        displacement = self.backward(self.response * pressure)
        gap = displacement - self.heights
        offset = -float(np.mean(gap[contact.in_contact]))
        gap += offset
        contact = contact.remeasured(
            rms_gradient=self.surface.rms_gradient,
            target_pressure=self.load,
            gap=gap,
            displacement=displacement,
            heights=self.heights,
            offset=offset,
        )
        # Peaceman and Rachford: 2 G (y - p) with y = (G + C)^-1 (2 G p - H + h).
        waves = 2 * self.magnitude * pressure + self.forward(self.heights - heights)
        both = self.magnitude + self.response
        both[0, 0] = 1.0
        waves = 2 * self.magnitude * (waves / both - pressure)
        waves[0, 0] = 0.0
        # In the metric in which steps shrink: sum |f|^2 / |C|.
        stiffness = 1 / np.where(self.magnitude > 0, self.magnitude, np.inf)
        return _State(
            contact=contact,
            step=self.backward(waves),
            size=float(np.sum(self._halves * stiffness * np.abs(waves) ** 2)),
        )

    @property
    def _halves(self) -> Array:
        """How often each column of half a spectrum counts in a sum over all wavevectors."""
        ny = self.surface.shape[1]
        columns = np.arange(ny // 2 + 1)
        return np.where((columns > 0) & (2 * columns < ny), 2.0, 1.0)

    def resistance(self, pressure: Array) -> dict[str, Any]:
        """Friction coefficient and its interval, by the slopes of the surface and by what the solid loses."""
        (nx, ny), waves, weight = self.surface.shape, self.forward(pressure), self._halves * self.qx
        if nx % 2 == 0:
            weight[nx // 2] = 0.0
        against = math.copysign(1.0, self.metric.velocity) / self.load
        slopes = against * float(np.sum(weight * (waves.conj() * self.forward(self.heights)).imag))
        power = np.abs(waves) ** 2
        heat = against * weight * self.response.imag * power
        losses = float(np.sum(heat))
        beyond = np.hypot(2 * scipy.fft.fftfreq(nx)[:, None], 2 * scipy.fft.rfftfreq(ny)[None, :]) > 0.5
        most = abs(against) * float(np.sum(np.abs(weight) * self.magnitude * power))
        correction = 0.5 * (slopes - losses) * (losses / most if most > 0 else 0.0)
        half = 2 * abs(correction) + 0.5 * abs(float(np.sum(heat[beyond])))
        friction = losses + correction
        return {
            "friction": friction,
            "friction_interval": (friction - half, friction + half),
            "slopes": slopes,
            "dissipation": losses,
        }

    def dressed(self, state: _State, status: Status, **counted: Any) -> SlidingContact:
        """Dress up the last state."""
        inner = state.contact
        arrays = (5 * _MEMORY + 10) * self.heights.nbytes + 3 * self.response.nbytes
        contact = replace(
            inner,
            heights=self.surface.heights,
            offset=inner.offset + self.level,
            status=status,
            tolerance=self.settings.tolerance,
            cost=self.clock.cost(
                **counted, unknowns=inner.gap.size, peak_bytes=inner.cost.peak_bytes + arrays
            ),
            provenance={
                "method": "boundary elements by FFT, pressure collocated at the grid points",
                "solver": "splitting of Peaceman and Rachford, accelerated, around elastic contacts on |C|",
                "tolerance": repr(self.settings.tolerance),
                "velocity": repr(float(self.metric.velocity)),
            },
        )
        return SlidingContact(
            contact=contact,
            velocity=float(self.metric.velocity),
            **self.resistance(inner.pressure),
            contraction=float(np.tan(np.abs(np.angle(self.response)).max() / 2)),
        )


class _Acceleration:
    """Anderson's extrapolation from the last steps of a fixed-point iteration."""

    def __init__(self) -> None:
        self._last: tuple[Array, Array] | None = None
        self._changes: deque[tuple[Array, Array]] = deque(maxlen=_MEMORY)

    @property
    def active(self) -> bool:
        """Whether the next point is more than a plain step away."""
        return len(self._changes) > 0

    def after(self, point: Array, step: Array) -> Array:
        """Return where to go from a point whose plain step is known."""
        if self._last is not None:
            before, stepped = self._last
            self._changes.append((point - before, step - stepped))
        self._last = point, step
        there = point + step
        if self.active:
            moved, changed = (np.array(column) for column in zip(*self._changes, strict=True))
            count = len(self._changes)
            weights = np.linalg.lstsq(changed.reshape(count, -1).T, step.ravel(), rcond=None)[0]
            there = there - np.tensordot(weights, moved + changed, axes=1)
        return there


def _iterated(problem: _Problem, start: Array | None) -> SlidingContact:
    """Step until the viscoelastic residuals are met; take back accelerated steps that do not pay."""
    settings, began = problem.settings, time.monotonic()
    memory, pressure = _Acceleration(), start
    heights = plain = problem.first(start)
    residual, last, best, since = math.inf, math.inf, math.inf, 0
    pairs, steps, inner_steps, status = 0.0, 0, 0, None
    while status is None:
        state = problem.pressed(
            heights,
            start=pressure,
            tolerance=max(_INNER * residual, _INNER_FLOOR * settings.tolerance),
            settings=settings.remaining(began),
        )
        steps, since = steps + 1, since + 1
        pairs += state.contact.cost.fft_pairs + _PAIRS
        inner_steps += state.contact.cost.iterations
        pressure = state.contact.pressure
        # Of penetration ten times the tolerance is allowed.
        residual = max(state.contact.residuals.complementarity, state.contact.residuals.penetration / 10)
        if residual < best:
            best, since = residual, 0
        if state.contact.residuals.within(settings.tolerance):
            status = Status.CONVERGED
        elif settings.expired(began):
            status = Status.TIME_LIMIT
        elif since >= _PATIENCE:
            status = Status.STAGNATED
        elif steps >= settings.max_iterations:
            status = Status.ITERATION_LIMIT
        if memory.active and state.size > last:
            memory = _Acceleration()
            heights = plain
            continue
        last, plain = state.size, heights + state.step
        heights = memory.after(heights, state.step)
    return problem.dressed(state, status, iterations=steps, fft_pairs=pairs, linear_iterations=inner_steps)
