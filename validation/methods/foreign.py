"""Solvers that nobody here wrote: run in a process of their own, and held to the pressures they return.

What counts is the pressure. Displacement, gap, contact set and residuals are computed from it by the response
of the elastic half-space; a solver's own word on any of them decides nothing.
"""

from __future__ import annotations

import contextlib
import importlib
import inspect
import math
import sys
import tempfile
import time
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from fem_contact import contact
from fem_contact.area import EDGE_CONSTANTS
from fem_contact.contact import ContactResult, Status, measure_residuals
from fem_contact.errors import NotConverged
from fem_contact.response import HalfSpace
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation import bounded
from validation.effects.base import Effect, Slots
from validation.methods.base import Claim, Cost, Grid, Gridded, Settings, Solved, Solver, example_field
from validation.methods.bem import FIXED_BYTES, FIXED_PAIRS
from validation.units import Duration, Memory, Table

__all__ = ["Foreign", "ForeignOptions", "claimed_in_own_process", "judged"]

Array = NDArray[np.float64]

#: Pairs of real 256 x 256 transforms per pair on the grid: a guess, as nobody here knows the algorithm.
_PAIRS = 1000.0
_BYTES_PER_POINT = 40 * 8
_SECONDS, _MEMORY = 600.0, 4 * 2**30


class ForeignOptions(Gridded):
    """A contact solver from elsewhere on these grids, its answer recomputed."""

    tolerance: Annotated[float, Field(gt=0, lt=1e-1)] = Field(
        default=1e-6, description="largest residual of the returned pressure that is accepted"
    )
    seconds: Duration | None = Field(default=None, description="time one solve may take; default: 10 min")
    memory: Memory | None = Field(default=None, description="memory one solve may take; default: 4 GiB")


class Foreign(Solver):
    """A solver of the elastic half-space without effects, in a process of its own.

    Attributes
    ----------
    accepted : float
        Tolerance that holds where none is said.
    """

    options: ClassVar[type[Table]] = ForeignOptions
    independent = True
    foreign = True
    half_space = True
    accepted: ClassVar[float] = 1e-6

    @abstractmethod
    def call(self, settings: Mapping[str, Any]) -> tuple[str, Mapping[str, Any]]:
        """Return the function as ``module:name``, and what it is told beyond surface, modulus and load."""

    def source(self, settings: Mapping[str, Any]) -> Settings:
        """Return what tells one version of the solver from another."""
        return ()

    def settings(self, options: Any) -> Settings:
        """Return what was said, and which version of the solver is told so."""
        given = {"tolerance": options.tolerance, "seconds": options.seconds, "memory": options.memory}
        said = tuple((name, value) for name, value in given.items() if value is not None)
        return said + self.source(dict(said))

    def claim(
        self, field: HeightField, *, mean_pressure: float, slots: Slots, settings: Mapping[str, Any]
    ) -> Claim:
        """Return what the solver says, unjudged.

        Raises
        ------
        NotConverged
            When it raised, crashed, took too much time or memory, or returned no pressures.
        """
        function, more = self.call(settings)
        return claimed_in_own_process(
            function,
            field,
            contact_modulus=slots.solid.contact_modulus,
            mean_pressure=mean_pressure,
            told={"tolerance": settings.get("tolerance", self.accepted), **more},
            seconds=float(settings.get("seconds", _SECONDS)),
            memory=int(settings.get("memory", _MEMORY)),
        )

    def solve(
        self,
        field: HeightField,
        *,
        mean_pressure: float,
        slots: Slots,
        settings: Mapping[str, Any],
        threads: int | None = None,
    ) -> Solved:
        """Ask the solver, and judge its pressures; its process has one thread."""
        claim = self.claim(field, mean_pressure=mean_pressure, slots=slots, settings=settings)
        return Solved(
            contact=judged(
                claim,
                field,
                solid=slots.solid,
                mean_pressure=mean_pressure,
                tolerance=float(settings.get("tolerance", self.accepted)),
                method=self.label,
            )
        )

    def cost(
        self,
        grid: Grid,
        lengths: tuple[float, float],
        *,
        settings: Mapping[str, Any],
        effects: Sequence[Effect],
        dearer: float,
    ) -> Cost:
        """Guess from the size of the grid."""
        points = grid[0] * grid[1]
        scale = points * math.log2(max(points, 2)) / (256**2 * 16)
        return Cost(
            pairs=FIXED_PAIRS + _PAIRS * scale,
            peak_bytes=FIXED_BYTES + _BYTES_PER_POINT * points,
            unknowns=points,
        )

    def words(self, options: Any) -> str:
        """Name it in a sentence."""
        return f"solver {self.label}"

    def rehearse(self, effects: Sequence[Effect], settings: Mapping[str, Any] | None = None) -> None:
        """Let its process import and compile what it needs; what it fails at, a solve says."""
        slots = Slots(solid=Solid(young=1.0, poisson=0.0))
        with contextlib.suppress(NotConverged):
            self.claim(example_field(16), mean_pressure=0.02, slots=slots, settings=settings or {})

    def edge_constant(self, result: ContactResult) -> float:
        """Return that of boundary elements: the residuals say that it is the same discrete problem."""
        return EDGE_CONSTANTS["bem"]


def judged(
    claim: Claim,
    field: HeightField,
    *,
    solid: Solid,
    mean_pressure: float,
    tolerance: float,
    method: str,
    displacement: Array | None = None,
) -> ContactResult:
    r"""Return the result that a pressure amounts to on the elastic half-space.

    .. math:: \hat u = \frac{2}{E^* q} \hat p, \qquad g = u - h + z, \qquad \sum p^+ g = 0

    A point is in contact where p exceeds g in units of E* h'_rms and h_rms: the rule of an active set, in
    which no pressure is small by itself.

    Parameters
    ----------
    claim : Claim
        Of which the pressure and the cost are used.
    field : HeightField
    solid : Solid
    mean_pressure : float
        The load that was asked for [Pa].
    tolerance : float
        Of the residuals; one above it makes the status say so.
    method : str
        Named in the provenance.
    displacement : (nx, ny) array, optional
        u [m] of a body that is no half-space, as a code of finite elements gives it: then this is believed.
    """
    pressure = claim.pressure
    modulus = solid.contact_modulus
    provenance = {"method": f"{method}, pressure and displacement; the rest recomputed", "element": "Hex1"}
    if displacement is None:
        displacement = half_space_displacement(pressure, field, solid=solid)
        # By its residuals it solves the discrete problem of our boundary elements, edges included.
        provenance = {"method": f"{method}, pressure alone; the rest recomputed", "element": "bem"}
    bearing = np.maximum(pressure, 0)
    total = float(bearing.sum())
    below = field.heights - displacement
    offset = float((bearing * below).sum() / total) if total > 0 else float(below.max())
    gap = displacement - field.heights + offset
    residuals = measure_residuals(
        pressure=pressure,
        gap=gap,
        heights=field.heights,
        lengths=field.lengths,
        contact_modulus=modulus,
        rms_gradient=field.rms_gradient,
        target_pressure=mean_pressure,
    )
    height, gradient = field.rms_height, field.rms_gradient
    stiffness = modulus * gradient / height if height > 0 and gradient > 0 else modulus / max(field.lengths)
    good = np.isfinite(pressure).all() and residuals.within(tolerance)
    return ContactResult(
        pressure=pressure,
        gap=gap,
        displacement=displacement,
        in_contact=(pressure > 0) & (pressure > stiffness * gap),
        at_bound=np.zeros(pressure.shape, dtype=bool),
        heights=field.heights,
        lengths=field.lengths,
        contact_modulus=modulus,
        offset=offset,
        mean_pressure=float(pressure.mean()),
        tolerance=tolerance,
        status=Status.CONVERGED if good else Status.NOT_CONFIRMED,
        residuals=residuals,
        cost=contact.Cost(
            wall_seconds=claim.wall_seconds,
            cpu_seconds=claim.cpu_seconds,
            iterations=claim.iterations,
            unknowns=pressure.size,
            peak_bytes=claim.peak_bytes,
        ),
        provenance={**provenance, "tolerance": repr(tolerance)},
    )


def half_space_displacement(pressure: Array, field: HeightField, *, solid: Solid) -> Array:
    """Return the displacement [m] of the half-space under pressures [Pa] at the points of a surface."""
    nx, ny = field.shape
    qx: Array = np.asarray(2 * np.pi * np.fft.fftfreq(nx, field.lengths[0] / nx), dtype=np.float64)
    qy: Array = np.asarray(2 * np.pi * np.fft.rfftfreq(ny, field.lengths[1] / ny), dtype=np.float64)
    compliance = HalfSpace(solid=solid).compliance(qx[:, None], qy[None, :])
    return np.asarray(np.fft.irfft2(compliance * np.fft.rfft2(pressure), s=field.shape))


def claimed_in_own_process(
    function: str,
    field: HeightField,
    *,
    contact_modulus: float,
    mean_pressure: float,
    told: Mapping[str, Any],
    seconds: float,
    memory: int,
) -> Claim:
    """Call a solver in a child process and return what it says.

    Parameters
    ----------
    function : str
        ``module:name``; the module may also lie in the folder the command was started in.
    field : HeightField
    contact_modulus, mean_pressure : float
        E* and p0 [Pa].
    told : mapping
        Keywords that it is given if it takes them.
    seconds, memory : float, int
        Bounds of the call [s, bytes].

    Raises
    ------
    NotConverged
        When nothing comes of it, with what happened.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "heights.npy"
        np.save(file, field.heights)
        request = {"lengths": list(field.lengths), "modulus": contact_modulus, "pressure": mean_pressure}
        try:
            said = bounded.call(
                serve,
                function,
                str(file),
                {**request, "told": dict(told), "folder": str(Path.cwd())},
                seconds=seconds,
                memory=memory,
            )
        except bounded.OutOfBounds as problem:
            raise NotConverged(
                f"{function}: {problem}; allow more (seconds, memory), or a coarser grid"
            ) from None
        except Exception as problem:  # whatever it raises is its answer
            raise NotConverged(f"{function}: raised {type(problem).__name__}: {problem}") from None
    pressure = np.array(said["pressure"], dtype=float)
    if pressure.shape != field.shape:
        raise NotConverged(
            f"{function}: pressures of shape {pressure.shape}: must have that of the heights, {field.shape}"
        )
    mask = said["in_contact"]
    return Claim(
        pressure=pressure,
        in_contact=None if mask is None or mask.shape != field.shape else mask.astype(bool),
        iterations=int(said["iterations"]),
        wall_seconds=float(said["wall_seconds"]),
        cpu_seconds=float(said["cpu_seconds"]),
        peak_bytes=int(said["peak_bytes"]),
    )


def serve(function: str, file: str, request: Mapping[str, Any]) -> dict[str, Any]:
    """Call a solver, in the child process; return its fields and what it took."""
    if request["folder"] not in sys.path:  # last: it must not stand in for an installed module
        sys.path.append(request["folder"])
    home, _, name = function.partition(":")
    solve: Any = importlib.import_module(home)
    for part in name.split("."):
        solve = getattr(solve, part)
    heights = np.load(file)
    told = {key: value for key, value in request["told"].items() if _takes(solve, key)}
    before = _peak_bytes(reset=True)
    clock, began = time.process_time(), time.perf_counter()
    answer = solve(
        heights,
        tuple(request["lengths"]),
        contact_modulus=request["modulus"],
        mean_pressure=request["pressure"],
        **told,
    )
    spent, passed = time.process_time() - clock, time.perf_counter() - began
    mask, iterations = _field(answer, "in_contact"), _field(answer, "iterations")
    return {
        "pressure": np.array(_pressure(answer), dtype=float),
        "in_contact": None if mask is None else np.array(mask, dtype=bool),
        "iterations": 0 if iterations is None else int(iterations),
        "cpu_seconds": spent,
        "wall_seconds": passed,
        "peak_bytes": max(_peak_bytes() - before, 0),
    }


def _takes(function: Callable[..., Any], keyword: str) -> bool:
    """Whether a function takes a keyword by name."""
    return keyword in inspect.signature(function).parameters


def _field(answer: Any, name: str) -> Any:
    if isinstance(answer, Mapping):
        return answer.get(name)
    return None if isinstance(answer, np.ndarray) else getattr(answer, name, None)


def _pressure(answer: Any) -> Any:
    """Return the pressures of an answer: the array itself, or what it calls so."""
    found = _field(answer, "pressure")
    return answer if found is None else found


def _peak_bytes(*, reset: bool = False) -> int:
    """Return the largest memory of this process since the last reset; 0 where the system does not say."""
    try:
        if reset:
            Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
        lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
        return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        return 0
