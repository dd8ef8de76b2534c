"""Wrong solvers of many kinds are caught, and what is wrong with each is named rightly or not at all."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fem_contact import GivenResponse, HeightField, NotConverged
from validation.cases import NotJudged, below, run_cases
from validation.cases.scorecard import Subject, elementary, rows, score
from validation.cases.scorecard.diagnosis import diagnose
from validation.cases.scorecard.elementary import WAVES, Transfer
from validation.solvers.bem import Bem


class Spoilt(Bem):
    """Boundary elements that press another problem (`before`), or whose pressures are spoilt (`after`)."""

    score_points = 16
    controls = frozenset()

    def __init__(self, before=lambda job: job, after=lambda p, job: p, mask=lambda mask, p: mask):
        self.before, self.after, self.mask = before, after, mask

    def claim(self, job):
        found = super().claim(self.before(job))
        pressure = np.array(self.after(found.pressure, job), dtype=float)
        return replace(found, pressure=pressure, in_contact=self.mask(found.in_contact, found.pressure))


def pressing(change):
    """Press a surface whose heights are changed."""

    def before(job):
        heights = np.ascontiguousarray(change(job.field.heights))
        return replace(job, field=HeightField(heights=heights, lengths=job.field.lengths))

    return before


def responding(compliance):
    """Press a solid of another compliance over that of the half-space, given q, qx, qy, dx."""

    def before(job):
        modulus, dx = job.model.solid.contact_modulus, job.field.lengths[0] / job.field.shape[0]

        def function(qx, qy):
            q = np.hypot(qx, qy)
            safe = np.where(q > 0, q, 1.0)
            return np.where(q > 0, 2 / (modulus * safe) * compliance(safe, qx, qy, dx), 0.0)

        response = GivenResponse(contact_modulus=modulus, function=function)
        return replace(job, model=replace(job.model, response=response))

    return before


def lattice(q, qx, qy, dx):
    """Compliance of second-order differences over that of the solid."""
    size = np.hypot(2 / dx * np.sin(qx * dx / 2), 2 / dx * np.sin(qy * dx / 2))
    return q / np.where(size > 0, size, q)


def stiffer(factor):
    def before(job):
        solid = replace(job.model.solid, young=factor * job.model.solid.young)
        return replace(job, model=replace(job.model, solid=solid))

    return before


def linear(p, job):
    """Full contact, whatever the load: nothing keeps the pressure from being negative."""
    field = job.field
    q = [2 * np.pi * np.fft.fftfreq(n, side / n) for n, side in zip(field.shape, field.lengths, strict=True)]
    stiff = job.model.solid.contact_modulus / 2 * np.hypot(q[0][:, None], q[1][None, :])
    return job.mean_pressure + np.fft.ifft2(stiff * np.fft.fft2(field.heights)).real


def loaded(factor):
    return lambda job: replace(job, load={"mean_pressure": factor * job.mean_pressure})


NOISE = np.random.default_rng(11)


def noisy(p, job):
    return p * (1 + 1e-3 * NOISE.standard_normal(p.shape))


def with_nan(p, job):
    p = p.copy()
    p[3, 4] = np.nan
    return p


def eroded(p):
    return np.where(np.roll(p, 1, axis=0) > 0, p, 0.0)


def with_load_of(p, left):
    return left * (p.sum() / left.sum()) if left.any() else p


def stale(answers=[]):  # noqa: B006
    """Return a solver that answers the question before."""

    def after(p, job):
        answers.append(p)
        before = answers[-2] if len(answers) > 1 else p
        return before if before.shape == p.shape else p

    return after


def loose(tolerance):
    """Set the tolerance of the iteration, by a function of the one asked for."""

    def before(job):
        return replace(job, settings={**job.settings, "tolerance": tolerance(job.settings["tolerance"])})

    return before


def square(change):
    return lambda p: change(p) if p.shape[0] == p.shape[1] else p


def answering(change):
    """Return the solver whose pressures are changed."""
    return Spoilt(after=lambda p, job: change(p))


def where_parted(change):
    """Change pressures that leave a gap."""
    return answering(lambda p: change(p) if (p == 0).any() else p)


TOO_SMALL = "points that carry load are not called contact"
TOO_LARGE = "points are called contact that carry no load"
RESPONSE, ANSWERS = "the response is not that of the half-space", "the same question has different answers"
#: Kind of fault, the solver, and what is said of it; nothing where its answers do not tell.
PLANTS = {
    "twice as stiff": (Spoilt(stiffer(2)), "the stiffness is 2 times that of E*"),
    "pressures times 1.1": (answering(lambda p: 1.1 * p), "pressures are 1.1 times what they should be"),
    "load times 0.9": (Spoilt(loaded(0.9)), "the load is 0.9 times the one asked for"),
    "heights upside down": (Spoilt(pressing(np.negative)), "the surface is pressed upside down"),
    "compression negative": (answering(np.negative), "compression is negative"),
    "moved by a cell": (
        answering(lambda p: np.roll(p, 1, axis=1)),
        "the pressure lies 0 and 1 cells beside the heights",
    ),
    "middles between points": (
        answering(lambda p: (p + np.roll(p, -1, axis=0)) / 2),
        "the pressure lies -0.5 and 0 cells beside the heights",
    ),
    "transposed": (answering(square(np.transpose)), "transposed"),
    "mirrored in x": (answering(lambda p: np.roll(p[::-1], 1, axis=0)), "mirrored in x"),
    "mirrored in y": (answering(lambda p: np.roll(p[:, ::-1], 1, axis=1)), "mirrored in y"),
    "backwards": (answering(lambda p: np.roll(p[::-1, ::-1], (1, 1), (0, 1))), "turned by 180 degrees"),
    "noise anew": (Spoilt(after=noisy), ANSWERS),
    "the answer before": (Spoilt(after=stale()), ANSWERS),
    "a NaN": (Spoilt(after=with_nan), "pressures are no finite numbers"),
    "no contact needed": (Spoilt(after=linear), "pressures below zero are allowed"),
    "all zero": (answering(np.zeros_like), "all pressures are zero"),
    "uniform": (answering(lambda p: 0 * p + p.mean()), "all points have one pressure"),
    "lifted": (where_parted(lambda p: 0.9 * p + 0.1 * p.mean()), "a constant is added to the pressures"),
    "peaks capped": (
        where_parted(lambda p: with_load_of(p, np.minimum(p, 0.5 * p.max()))),
        "the highest pressures are cut off",
    ),
    "edges eroded, load kept": (answering(lambda p: with_load_of(p, eroded(p))), ""),
    "contact named too small": (Spoilt(mask=lambda mask, p: mask & np.roll(mask, 1, axis=0)), TOO_SMALL),
    "contact named too large": (Spoilt(mask=lambda mask, p: mask | np.roll(mask, 1, axis=0)), TOO_LARGE),
    "contact by rounding": (
        Spoilt(after=lambda p, job: np.maximum(p, 1e-14 * p.mean()), mask=lambda mask, p: None),
        TOO_LARGE,
    ),
    "a layer for a half-space": (Spoilt(responding(lambda q, qx, qy, dx: np.tanh(q * 0.1))), RESPONSE),
    "short waves too soft": (Spoilt(responding(lambda q, qx, qy, dx: 1 + 0.02 * q)), RESPONSE),
    "a tolerance of its own": (Spoilt(loose(lambda asked: 3e-3)), ""),
    "tolerance a thousand times as loose": (
        Spoilt(loose(lambda asked: min(1e3 * asked, 9e-3))),
        "the iteration ends before its tolerance is met",
    ),
}
TOLD = {"repeatable", "tension", "full-contact", "load", "contact-set", "honesty", "symmetry"}


def verdicts_of(subject):
    return {one.case: one.word for one in run_cases([row for row in rows(subject) if row.name in TOLD])}


@pytest.mark.parametrize("kind", PLANTS)
def test_a_wrong_solver_fails_a_row_and_is_told_what_is_wrong_or_nothing(kind):
    solver, words = PLANTS[kind]
    subject = Subject(name=kind, solver=solver, settings={})
    assert "FAILS" in verdicts_of(subject).values()
    found = diagnose(subject)
    assert words in found
    assert bool(found) == bool(words)


@pytest.mark.parametrize("solver", [Spoilt(), Spoilt(responding(lattice))], ids=["plain", "lattice"])
def test_a_right_solver_is_not_accused_whatever_its_cells(solver):
    subject = Subject(name="right", solver=solver, settings={})
    assert "FAILS" not in verdicts_of(subject).values()
    assert diagnose(subject) == ""


def test_a_solver_without_answers_is_said_to_have_none():
    def fail(job):
        raise NotConverged("it raised ValueError")

    assert diagnose(Subject(name="mute", solver=Spoilt(fail), settings={})) == (
        "it gives no answer: it raised ValueError"
    )


def test_what_a_solver_of_this_process_raises_is_told_by_its_rows():
    def fail(job):
        raise ZeroDivisionError("by zero")

    card = score(Subject(name="raising", solver=Spoilt(fail), settings={}))
    assert {verdict.error for verdict in card.failed} == {"ZeroDivisionError: by zero"}
    assert card.diagnosis == ""


@pytest.mark.parametrize("shift", [(1.0, 0.0), (0.0, -1.0), (2.0, 3.0)])
def test_a_shift_is_told_along_each_axis(shift):
    n = 32
    turns = np.array([kx * shift[0] + ky * shift[1] for kx, ky, *_ in WAVES])
    made = {"allowed": np.full(len(WAVES), 0.01), "exact": np.zeros((n, n)), "pressed": None}
    assert Transfer(ratio=np.exp(-2j * np.pi * turns / n), **made).shift == pytest.approx(shift)
    assert Transfer(ratio=np.exp(1j * np.arange(len(WAVES))), **made).shift is None


@pytest.mark.parametrize(
    ("off", "falls", "finer", "excused"),
    [
        (0.05, False, 0.5, True),
        (0.2, False, 0.5, False),  # waves are wrong by more than the cells are
        (0.005, False, 0.5, False),  # waves are those of the half-space
        (0.05, True, 0.5, False),  # a smaller tolerance helps
        (0.05, False, 0.9, False),  # a finer grid does not
    ],
)
def test_residuals_are_another_discretisations_only_if_all_says_so(monkeypatch, off, falls, finer, excused):
    residuals = {16: 1.0, 32: 1.0, 64: finer}

    class Stub:
        points, pressure_error = 16, 0.01

        def press(self, surface, _load):
            found = SimpleNamespace(complementarity=residuals[surface.shape[0]])
            return SimpleNamespace(result=SimpleNamespace(residuals=found))

    transfer = SimpleNamespace(ratio=np.array([1.0, 1 + off + 0j]), allowed=np.array([0.1, 0.1]))
    monkeypatch.setattr(elementary, "full_contact_transfer", lambda _: transfer)
    monkeypatch.setattr(elementary, "residuals_fall", lambda _: falls)
    missed = [below("complementarity", 1.0, 1e-9)]
    if excused:
        with pytest.raises(NotJudged, match=r"another discretisation: .* makes 0\.5 of 1$"):
            elementary.judge_residuals(Stub(), missed)
    else:
        assert elementary.judge_residuals(Stub(), missed) is missed
    met = [below("complementarity", 1e-10, 1e-9)]
    assert elementary.judge_residuals(None, met) is met
