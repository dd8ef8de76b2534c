"""One results folder, read from beginning to end."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from validation.audit.dataset import Result
from validation.audit.ledger import Ledger
from validation.audit.runs import Run, audit_run
from validation.audit.stored import Stored, wavevectors
from validation.audit.values import judge_shown, value_ledger


def audit(folder: Path) -> Ledger:
    """Compute every number of a run again from its stored fields, and compare all places where it stands.

    `folder` holds a run with at least one solver, a sweep of such a scene, or a study; the ledger has every
    number found, beside the one recomputed.

    An OSError, ValueError or LookupError for a folder that holds no finished run of this version.
    """
    try:
        result = Result(folder)
    except RecursionError:
        raise ValueError("a file is nested too deeply") from None
    kind = result.record.get("kind")
    if kind in ("study", "claims", "paper"):
        return value_ledger(result)
    if kind not in ("run", "sweep"):
        raise LookupError(f"a {kind} stores no field")
    ledger, runs = audit_run(result)
    judge_shown(result, ledger)
    for run in runs:
        for key, solve in run.solves.items():
            judge_fields(key[3], solve, run, ledger)
        judge_surfaces(run, ledger)
    return ledger


def judge_fields(k: int, solve: Stored, run: Run, ledger: Ledger) -> None:
    """Judge one solve: what was pressed is what was asked for, and the fields obey their definitions."""
    place = f"{solve.method} {solve.grid[0]}x{solve.grid[1]} {solve.shift}, surface {k}"
    height = np.ptp(solve.h) or np.ptp(solve.u) or 1.0
    ledger.number(place, "E* [Pa]", solve.modulus, run.surface_modulus)
    pressure = run.pressure(k)
    if not (math.isnan(pressure) or run.holds_distance):
        ledger.number(place, "mean pressure [Pa]", solve.mean_pressure, pressure, rtol=1e-6)
    misfit = np.max(np.abs(solve.gap - (solve.u - solve.h + float(solve.attrs["offset"]))))
    ledger.number(place, "gap less u - h + offset, over the height", misfit / height, 0.0, atol=1e-9)
    ledger.same(place, "status", solve.attrs["status"], "CONVERGED")
    residuals = solve.residuals(solve.mean_pressure if run.holds_distance else pressure)
    if residuals is None:
        ledger.unread.append("residuals under an attraction of another law than the exponential")
    for name, value in (residuals or {}).items():
        stands = solve.stored_residuals[name]
        ledger.number(place, f"residual, {name}", abs(stands), value, rtol=1e-6, atol=1e-13)
    if solve.method == "bem" and run.depth is None:
        ledger.unread.append("displacement against pressure of a solid in layers")
    elif solve.method == "bem" and run.depth is not None:
        misfit = _elastic_misfit(solve, run.depth, poisson=float(run.scene["solid"]["poisson"]))
        ledger.number(place, "u against 2 p / (E* q)", misfit, 0.0, atol=1e-6)


def _elastic_misfit(solve: Stored, depth: float, *, poisson: float) -> float:
    """Largest difference between u and the answer of the solid to p, over the largest u, without means."""
    q = wavevectors(solve.p.shape, solve.lengths)
    q[0, 0] = np.inf
    share = np.ones_like(q)
    if math.isfinite(depth):
        # A layer bonded to a rigid base; beyond q d = 300 it is a half-space to the last bit.
        d, k = np.minimum(q * depth, 300.0), 3 - 4 * poisson
        share = (2 * k * np.sinh(2 * d) - 4 * d) / (2 * k * np.cosh(2 * d) + 4 * d**2 + 1 + k**2)
    exact = np.fft.ifft2(2 * share * np.fft.fft2(solve.p) / (solve.modulus * q)).real
    size = np.max(np.abs(exact))
    return float(np.max(np.abs(solve.u - solve.u.mean() - exact))) / (size or 1.0)


def judge_surfaces(run: Run, ledger: Ledger) -> None:
    """Judge that all solves of a realisation press one surface, moved as said, and others another."""
    if run.measured:
        ledger.unread.append("heights of a measured surface against its file")
        return
    alike: dict[str, list[bytes]] = {}
    for (method, grid, shift, k), solve in run.solves.items():
        if shift == (0.0, 0.0):
            alike.setdefault(f"{method} {grid[0]}x{grid[1]}", []).append(solve.h.tobytes())
        if not run.resolved(solve):
            continue
        place = f"{method} {grid[0]}x{grid[1]} {shift}, surface {k}"
        gradients = math.sqrt(solve.roughness[1]), math.sqrt(run.moments(k)[1])
        ledger.number(place, "h'_rms of the surface pressed", *gradients, rtol=1e-8)
        still = run.solves.get((method, grid, (0.0, 0.0), k))
        if shift != (0.0, 0.0) and still is not None:
            x, y = (np.exp(2j * np.pi * np.fft.fftfreq(n) * s) for n, s in zip(grid, shift, strict=True))
            moved = np.fft.ifft2(np.fft.fft2(still.h) * x[:, None] * y[None, :]).real
            misfit = np.max(np.abs(solve.h - moved)) / (np.ptp(solve.h) or 1.0)
            ledger.number(place, "heights against those moved by the shift", misfit, 0.0, atol=1e-8)
    for place, heights in alike.items():
        ledger.same(place, "surfaces that differ", len(set(heights)), len(heights))
