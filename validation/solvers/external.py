"""Solvers that nobody here wrote: run in a process of their own, and held to the pressures they return.

What counts is the pressure. Displacement, gap, contact set and residuals are computed from it by the response
of the elastic solid; a solver's own word on any of them decides nothing.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import inspect
import operator
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from fem_contact import contact
from fem_contact.contact import ContactResult, Status, measure_residuals
from fem_contact.errors import NotConverged
from fem_contact.response import BondedLayer, Response
from fem_contact.surface.heights import wavevectors
from validation import sandbox
from validation.arrays import Array
from validation.effects.base import Effect
from validation.solvers.base import Claim, Cost, Gridded, Job, Settings, Size, Solved, Solver, example_job
from validation.units import Duration, Memory, Table, key

if TYPE_CHECKING:
    from validation.scenes.problem import ContactProblem

#: Pairs of real 256 x 256 transforms per pair on the grid: a guess, as nobody here knows the algorithm.
_PAIRS = 1000.0
_BYTES_PER_POINT = 40 * 8
_SECONDS, _MEMORY = 600.0, 4 * 2**30
#: Characters of what a solver raises that are repeated.
_MOST_WORDS = 500


class ExternalOptions(Gridded):
    """A contact solver from elsewhere on these grids, its answer recomputed."""

    tolerance: float = key("largest residual of the returned pressure that is accepted", 1e-6, gt=0, lt=1e-1)
    seconds: Duration | None = key("time one solve may take; default: 10 min", None)
    memory: Memory | None = key("memory one solve may take; default: 4 GiB", None)


class ExternalSolver(Solver):
    """A solver of the elastic half-space, in a process of its own.

    Its function is given what it takes by name, of: ``tolerance``; ``offset`` [m] (then ``mean_pressure`` is
    None), ``max_iterations``; ``hardness`` [Pa], ``thickness`` [m] and ``poisson`` where `slots` says so.
    """

    options: ClassVar[type[Table]] = ExternalOptions
    independent = True
    foreign = True
    setting_keys = ("tolerance", "seconds", "memory")
    accepted: ClassVar[float] = 1e-6  # Tolerance that holds where none is said
    package: ClassVar[str | None] = None  # What must be installed; its version is part of the recipe
    install: ClassVar[str] = "pip install 'fem-contact[peers]'"  # How
    controls: ClassVar[frozenset[str]] = frozenset({"offset", "max_iterations"})

    def available(self) -> str | None:
        """Say what to install."""
        if self.package is None or importlib.util.find_spec(self.package) is not None:
            return None
        return f"{self.package} is not installed; install it with: {self.install}"

    def function(self, settings: Mapping[str, Any]) -> str:
        """Return the function as ``module:name``; ``solve`` beside the class, unless one says else."""
        return f"{type(self).__module__}:solve"

    def handles(self, effect: type[Effect]) -> bool:
        """Whether the slot is one of its own; of the solids with a slot, it knows the layer."""
        return super().handles(effect) and (effect.slot != "response" or effect.kind_name() == "thickness")

    def check(self, options: Any, problem: ContactProblem, effects: Sequence[Effect]) -> None:
        """Refuse a layer that is not bonded to its base."""
        self.check_bodies(problem, effects)

    def controlled(self, settings: Mapping[str, Any]) -> frozenset[str]:
        """Return which controls its function takes; none where it cannot be imported."""
        try:
            taken = sandbox.call(keywords, self.function(settings), str(Path.cwd()), seconds=_SECONDS)
        except Exception:  # what is wrong with it, a solve says
            return frozenset()
        return self.controls & frozenset(taken)

    def settings(self, options: Any) -> Settings:
        """Return what was said, and which version of the solver is told so."""
        settings = super().settings(options)
        if self.package is not None:
            with contextlib.suppress(metadata.PackageNotFoundError):
                settings += (("version", metadata.version(self.package)),)
        return settings

    def claim(self, job: Job) -> Claim:
        """Return what the solver says, unjudged; the settings bound its ``seconds`` and ``memory`` [bytes].

        A NotConverged when it raised, crashed, took too much time or memory, or returned no pressures.
        """
        function = self.function(job.settings)
        field, model, settings = job.field, job.model, job.settings
        load: dict[str, Any] = {"mean_pressure": None, **job.load}
        given = {"contact_modulus": model.solid.contact_modulus, "mean_pressure": load.pop("mean_pressure")}
        parameters = {"tolerance": self.accepted}
        parameters |= {name: settings[name] for name in ("tolerance", *self.controls) if name in settings}
        if model.pressure_bound is not None:
            parameters["hardness"] = model.pressure_bound
        if isinstance(model.response, BondedLayer):
            parameters |= {"thickness": model.response.thickness, "poisson": model.solid.poisson}
        parameters |= load
        try:
            claim: Claim = sandbox.call(
                serve,
                function,
                str(Path.cwd()),
                field.heights,
                field.lengths,
                given,
                parameters,
                seconds=float(settings.get("seconds", _SECONDS)),
                memory=int(settings.get("memory", _MEMORY)),
            )
        except sandbox.OutOfBounds as error:
            raise NotConverged(
                f"{function}: {error}; allow more (seconds, memory), or a coarser grid"
            ) from None
        except Exception as error:  # whatever it raises is its answer
            line = " ".join(str(error).split())[:_MOST_WORDS]
            raise NotConverged(f"{function}: raised {type(error).__name__}: {line}") from None
        pressure, mask = np.array(claim.pressure), claim.in_contact
        if pressure.shape != field.shape:
            words = f"of shape {pressure.shape}: must have that of the heights, {field.shape}"
            raise NotConverged(f"{function}: pressures {words}")
        if not np.isfinite(pressure).all():
            raise NotConverged(f"{function}: pressures are not finite")
        named = mask if mask is not None and mask.shape == field.shape else None
        return replace(claim, pressure=pressure, in_contact=named)

    def solve(self, job: Job) -> Solved:
        """Ask the solver, and judge its pressures; its process has one thread."""
        _ = job.mean_pressure  # no distance: who wrote it may or may not have thought of them
        accepted_job = replace(job, settings={"tolerance": self.accepted, **job.settings})
        return Solved(contact=verified(self.claim(job), accepted_job, method=self.label))

    def cost(self, size: Size) -> Cost:
        """Assume memory and time, as pairs of FFTs, of an efficient code on a grid of this size."""
        return size.cost(_PAIRS * size.transforms, _BYTES_PER_POINT * size.points)

    def warm_up(self, effects: Sequence[Effect], settings: Mapping[str, Any]) -> None:
        """Solve a small contact, so that the process has imported and compiled what it needs."""
        with contextlib.suppress(NotConverged):
            self.claim(example_job(16, **settings))


def verified(
    claim: Claim,
    job: Job,
    *,
    method: str,
    response: Response | None = None,
    element: str = "bem",
    displacement: Array | None = None,
) -> ContactResult:
    r"""Return the result that a pressure amounts to on an elastic solid.

    .. math:: \hat u = C(q)\, \hat p, \qquad g = u - h + z, \qquad \sum_{0 < p < H} p g = 0

    A point is in contact where p exceeds g in units of E* h'_rms and h_rms: the rule of an active set, in
    which no pressure is small by itself. Where it reaches the hardness the gap may be negative.

    Of the `claim` pressure and cost are used; a residual above the tolerance of the settings of the `job`
    makes the status say so. `response` is C(q) of the solid at the grid points, that of the job if not given;
    the edges are those of an `element`: "bem" by its residuals, or a finite element. A `displacement` [m]
    that a code of finite elements gives is believed, and not recomputed.
    """
    response = response or job.model.felt_response
    field, bound, tolerance = job.field, job.model.pressure_bound, float(job.settings["tolerance"])
    pressure, modulus = claim.pressure, response.contact_modulus
    source = "pressure and displacement" if displacement is not None else "pressure alone"
    if displacement is None:
        qx, qy = wavevectors(field.shape, field.lengths)
        compliance = response.compliance(qx[:, None], qy[None, :])
        displacement = np.fft.irfft2(compliance * np.fft.rfft2(pressure), s=field.shape)
    at_bound = np.zeros(pressure.shape, dtype=bool) if bound is None else pressure >= bound * (1 - tolerance)
    # The gap vanishes in the mean over what bears.
    below, bearing = field.heights - displacement, np.where(at_bound, 0.0, np.maximum(pressure, 0))
    total = float(bearing.sum())
    offset = float((bearing * below).sum() / total) if total > 0 else float(below.max())
    gap = displacement - field.heights + offset
    residuals = measure_residuals(
        pressure=pressure,
        gap=gap,
        heights=field.heights,
        lengths=field.lengths,
        contact_modulus=modulus,
        rms_gradient=field.rms_gradient,
        target_pressure=job.load.get("mean_pressure"),
        at_bound=at_bound,
    )
    # Pressure over gap [Pa/m] that tells contact; of a flat surface E* / L.
    height, gradient = field.rms_height, field.rms_gradient
    rough = height > 0 and gradient > 0
    stiffness = modulus * gradient / height if rough else modulus / max(field.lengths)
    good = np.isfinite(pressure).all() and residuals.within(tolerance)
    good = good and (bound is None or bool(pressure.max() <= bound * (1 + 10 * tolerance)))
    return ContactResult(
        pressure=pressure,
        gap=gap,
        displacement=displacement,
        in_contact=(pressure > 0) & (pressure > stiffness * gap),
        at_bound=at_bound,
        heights=field.heights,
        lengths=field.lengths,
        contact_modulus=modulus,
        offset=offset,
        mean_pressure=float(pressure.mean()),
        tolerance=tolerance,
        status=Status.CONVERGED if good else Status.NOT_CONFIRMED,
        residuals=residuals,
        cost=claim.cost,
        provenance={
            "method": f"{method}, {source}; the rest recomputed",
            "element": element,
            "tolerance": repr(tolerance),
        },
    )


def _imported(function: str, folder: str) -> Any:
    """Return a function by ``module:name``; the module may lie in a folder."""
    if folder not in sys.path:  # last: it must not stand in for an installed module
        sys.path.append(folder)
    home, _, name = function.partition(":")
    return operator.attrgetter(name)(importlib.import_module(home))


def keywords(function: str, folder: str) -> list[str]:
    """Return the names of what a function takes; called in the child process."""
    return list(inspect.signature(_imported(function, folder)).parameters)


def serve(
    function: str,
    folder: str,
    heights: Array,
    lengths: Sequence[float],
    given: Mapping[str, Any],
    parameters: Mapping[str, Any],
) -> Claim:
    """Call a solver, in the child process; return what it says and what it took."""
    solve, taken = _imported(function, folder), keywords(function, folder)
    more = {name: value for name, value in parameters.items() if name in taken}
    heights = heights.copy()  # its own, to write to
    before = _peak_bytes(reset=True)
    clock, began = time.process_time(), time.perf_counter()
    answer = solve(heights, tuple(lengths), **given, **more)
    spent, passed = time.process_time() - clock, time.perf_counter() - began
    get: Any = answer.get if isinstance(answer, Mapping) else lambda name: getattr(answer, name, None)
    pressure, mask, converged = map(get, ("pressure", "in_contact", "converged"))
    return Claim(
        pressure=np.asarray(answer if pressure is None else pressure).astype(float, casting="same_kind"),
        in_contact=None if mask is None else np.array(mask, dtype=bool),
        converged=None if converged is None else bool(converged),
        cost=contact.Cost(
            wall_seconds=passed,
            cpu_seconds=spent,
            iterations=int(get("iterations") or 0),
            unknowns=heights.size,
            peak_bytes=max(_peak_bytes() - before, 0),
        ),
    )


def _peak_bytes(*, reset: bool = False) -> int:
    """Return the largest memory of this process since the last reset; 0 where the system does not say."""
    try:
        if reset:
            Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
        lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
        return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        return 0
