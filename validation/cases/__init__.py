"""Cases with a known answer: one module for each claim, found by name, checked by `fem-contact validate`.

A case says in ``claim`` what holds, and its ``run`` yields the checks that decide it: numbers beside a
reference, with a tolerance that comes from an error estimate. A module of this package has each as a function
under `case`, whose docstring begins with the claim, or, where several share one, in a tuple ``CASES``. What
is asked of any solver is a row of the scorecard.
"""

from __future__ import annotations

import importlib
import math
import pkgutil
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from fem_contact.settings import one_blas_thread
from validation.errors import UsageError, did_you_mean
from validation.measurements.statistics import order_of_convergence
from validation.report.papers import cited


class NotJudged(Exception):
    """Why a claim is not judged of a solver: not answered, not tried, or not read, as another one fails."""


@dataclass(frozen=True, kw_only=True)
class Check:
    """One number beside its reference."""

    quantity: str  # What was computed, with its unit if it has one
    computed: float
    reference: float
    tolerance: float  # Largest difference that counts as agreement, in the unit of the quantity
    ladder: tuple[tuple[float, float], ...] = ()  # Resolution and error, where the number is their order

    @property
    def used(self) -> float:
        """Distance over the tolerance: at most 1 passes; infinite where nothing was computed."""
        apart = abs(self.computed - self.reference)
        if not math.isfinite(apart):
            return math.inf
        return apart / self.tolerance if self.tolerance > 0 else (0.0 if apart == 0 else math.inf)

    @property
    def passed(self) -> bool:
        """Whether the two agree; a NaN never does."""
        return self.used <= 1


#: What decides a claim.
Checks: TypeAlias = Iterable[Check]


def near(quantity: str, computed: ArrayLike, reference: ArrayLike, tolerance: ArrayLike) -> Check:
    """Return a check of one number, the tolerance in the unit of the quantity."""
    value, known, allowed = (float(np.asarray(each).item()) for each in (computed, reference, tolerance))
    return Check(quantity=quantity, computed=value, reference=known, tolerance=allowed)


def relative(quantity: str, computed: ArrayLike, reference: ArrayLike, tolerance: float) -> Check:
    """Return a check of one number, the tolerance as a part of the reference."""
    return near(quantity, computed, reference, abs(float(np.asarray(reference).item())) * tolerance)


def below(quantity: str, computed: ArrayLike, bound: ArrayLike) -> Check:
    """Return a check that a size does not exceed a bound: of an array, that its largest element does not."""
    size = np.asarray(computed, dtype=float)
    return near(quantity, size if size.size == 1 else np.max(np.abs(size)), 0.0, bound)


def within(quantity: str, computed: ArrayLike, low: float, high: float) -> Check:
    """Return a check that a number lies between two."""
    return near(quantity, computed, (low + high) / 2, (high - low) / 2)


def order(
    quantity: str, resolutions: Sequence[float], errors: Sequence[float], *, expected: float, tolerance: float
) -> Check:
    """Return a check of the order at which errors, positive, fall as points along a side (or steps) grow.

    The tolerance is how far these resolutions, coarse to fine, may be from the limit in which it holds.
    """
    slope = order_of_convergence(1 / np.asarray(resolutions), errors) if min(errors) > 0 else math.nan
    ladder = tuple((float(n), float(error)) for n, error in zip(resolutions, errors, strict=True))
    return Check(quantity=quantity, computed=slope, reference=expected, tolerance=tolerance, ladder=ladder)


#: What tolerances come from.
TOLERANCES = {
    "rounding": "rounding, and quadratures to a known digit",
    "solver": "the tolerance that the solver is asked for",
    "grid": "the order and the constant of the error of a grid or step",
    "estimate": "what the reference itself leaves out, or the scatter of what was drawn",
}


@dataclass(frozen=True, kw_only=True)
class Case:
    """A claim with a known answer, and `run`, which computes the checks that decide it.

    It is `quick` if it takes seconds rather than minutes; `source` is that of the reference, `tolerance`
    one of `TOLERANCES`, `solver` whom the claim is about, where there are several. That of a row of the
    scorecard, which is about any solver, takes a `scorecard.Subject`.
    """

    name: str
    claim: str
    run: Callable[..., Checks]
    source: str = ""
    quick: bool = True
    solver: str = ""
    tolerance: str = "rounding"


def case(name: str, *, source: str = "", **fields: Any) -> Callable[[Callable[..., Checks]], Case]:
    """Make a `Case` of the function that follows, which yields the checks; `fields` are those of `Case`.

    Its claim is the first line of the function's docstring.
    """

    def made(run: Callable[..., Checks]) -> Case:
        claim = (run.__doc__ or "").partition("\n")[0]
        return Case(name=name, claim=claim, run=run, source=cited(source), **fields)

    return made


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """How a case ended: its checks, or the `error` that it ended with, or why it was `left_out`."""

    case: str
    claim: str
    source: str
    checks: tuple[Check, ...] = ()
    seconds: float = math.nan
    error: str | None = None
    left_out: str = ""
    solver: str = ""
    tolerance: str = "rounding"

    @property
    def passed(self) -> bool:
        """Whether there were checks and all of them passed."""
        return self.error is None and bool(self.checks) and all(check.passed for check in self.checks)

    @property
    def row(self) -> str:
        """Name of the claim, of whichever solver."""
        return self.case.removesuffix(f"-{self.solver}")

    @property
    def word(self) -> str:
        """The verdict in a word: holds, FAILS or not judged."""
        return "not judged" if self.left_out else "holds" if self.passed else "FAILS"

    @property
    def why(self) -> str:
        """Why it does not hold: the error, why it was left out, or the check that is farthest off."""
        if self.error or self.left_out or not self.checks:
            return self.error or self.left_out or "no number came"
        worst = max(self.checks, key=lambda check: check.used)
        found = "not determinable" if math.isnan(worst.computed) else f"{worst.computed:.4g}"
        return f"{worst.quantity} is {found}, not {worst.reference:.4g} +- {worst.tolerance:.2g}"

    @property
    def used(self) -> float:
        """Largest difference over its tolerance; infinite where nothing could be computed."""
        if self.error is not None or not self.checks:
            return math.inf
        return max(check.used for check in self.checks)

    def summary(self) -> dict[str, Any]:
        """Everything as JSON-ready data."""
        checks = [{**asdict(check), "passed": check.passed} for check in self.checks]
        return {**asdict(self), "checks": checks, "passed": self.passed, "over_tolerance": self.used}


def all_cases() -> tuple[Case, ...]:
    """Return the cases of every module of this package, and those of the scorecard for each own solver."""
    # A folder is no module of cases: a scorecard's are made for a solver.
    scorecard = importlib.import_module(f"{__name__}.scorecard")
    names = [info.name for info in pkgutil.iter_modules(__path__) if not info.ispkg and info.name[0] != "_"]
    modules = (importlib.import_module(f"{__name__}.{name}") for name in sorted(names))
    return (*scorecard.own_cases(), *(case for module in modules for case in cases_of(vars(module))))


def cases_of(names: Mapping[str, object]) -> Iterator[Case]:
    """Yield the cases of a module, in the order in which they stand there."""
    yield from (value for value in names.values() if isinstance(value, Case))
    yield from cast("tuple[Case, ...]", names.get("CASES", ()))


def chosen_cases(names: Sequence[str], *, quick: bool) -> tuple[Case, ...]:
    """Return cases by name, or all; with `quick` only those that take seconds.

    A name also chooses the cases that begin with it and a hyphen.

    A UsageError for a name that chooses nothing.
    """
    known = all_cases()
    for name in names:
        if name in _RENAMED:
            raise UsageError(f"case {name!r}: is called {_RENAMED[name]} now")
        if not any(_chooses(name, case) for case in known):
            families = dict.fromkeys(case.name.rpartition("-")[0] for case in known)
            hint = did_you_mean(name, (*families, *(case.name for case in known)))
            raise UsageError(f"case {name!r}: no such case{hint}; listed by: fem-contact validate --list")
    wanted = [case for case in known if not names or any(_chooses(name, case) for name in names)]
    return tuple(case for case in wanted if case.quick or not quick)


#: Cases that became rows of the scorecard.
_RENAMED = {
    "bem-controls": "offset-bem",
    "bem-egg-box-full": "near-full-bem",
    "bem-grids": "nested-grids-bem",
    "bem-layers": "bodies-layers",
    "bem-symmetries": "symmetry-bem",
    "block-hertz": "hertz-reduced",
    "fem-against-bem": "against-bem-fem",
}


def _chooses(name: str, case: Case) -> bool:
    return case.name == name or case.name.startswith(name + "-")


def run_cases(cases: Iterable[Case], *, tell: Callable[[str], None] | None = None) -> Iterator[Verdict]:
    """Run cases and yield their verdicts; a case that raises has failed, and the others go on."""
    for case in cases:
        began, error, left_out = time.perf_counter(), None, ""
        checks: tuple[Check, ...] = ()
        try:
            with one_blas_thread():
                checks = tuple(case.run())
        except NotJudged as problem:
            left_out = str(problem)
        except Exception as problem:
            error = f"{type(problem).__name__}: {problem}"
        ended: dict[str, Any] = {"checks": checks, "error": error, "left_out": left_out}
        ended |= {name: getattr(case, name) for name in ("claim", "source", "solver", "tolerance")}
        verdict = Verdict(case=case.name, seconds=time.perf_counter() - began, **ended)
        if tell is not None:
            outcome = {"holds": "passed", "FAILS": "FAILED"}.get(verdict.word, verdict.word)
            why = "" if verdict.passed else f": {verdict.why}"
            tell(f"{outcome}  {case.name}  ({verdict.seconds:.1f} s){why}")
        yield verdict
