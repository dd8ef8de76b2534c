"""`fem-contact run --mpi`: the boundary elements of a scene, each solve shared out over processes of MPI."""

from __future__ import annotations

import contextlib
import json
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import typer
from rich.table import Table

from fem_contact import bem
from fem_contact.area import ContactAreas
from fem_contact.bem import parallel
from fem_contact.errors import FemContactError, NotConverged
from validation.cli.options import print_json, say, show
from validation.effects.base import ContactModel, Effect
from validation.errors import RunFailed, UsageError
from validation.execution.press import Press, solves_of
from validation.files import read_record, write_record
from validation.measurements.measurement import limit_over
from validation.scenes.checks import check_scene
from validation.scenes.problem import realise
from validation.scenes.scene import Scene
from validation.scenes.surfaces import waves_drawn
from validation.scenes.sweep import Sweep
from validation.scenes.tables import FileSurface

#: Where Open MPI, MPICH and Slurm say which process this is, should MPI itself be missing.
_RANKS = ("OMPI_COMM_WORLD_RANK", "PMI_RANK", "SLURM_PROCID")


def run_parallel(scene: Scene | Sweep, folder: Path, *, as_json: bool, unfit: Mapping[str, Any]) -> None:
    """Press the surface of a scene on each of its grids of boundary elements; areas, their limit, fields.

    Finished grids found in the folder are used again. Every process calls this, the first one speaks.
    """
    try:
        comm = parallel.communicator()
    except FemContactError as error:
        if any(os.environ.get(name, "0") != "0" for name in _RANKS):
            raise typer.Exit(2) from None
        raise UsageError(f"--mpi: {error}") from None
    with _together(comm):
        for name, given in unfit.items():
            if given:
                raise UsageError(f"{name}: does not go with --mpi; leave it out")
        if isinstance(scene, Sweep):
            raise UsageError("[sweep]: makes it many scenes; --mpi runs one")
        solves = _solves(scene)
        rows = [_solved(solve, folder, comm) for solve in solves]
        resolved = [solve.problem.resolved_by(solve.grid) for solve in solves]
        if comm.rank == 0:
            _print(rows, folder, comm.size, resolved=resolved, as_json=as_json)


@contextlib.contextmanager
def _together(comm: Any) -> Iterator[None]:
    """End all processes when one fails: a mistake in the request in the words of the first, once."""
    try:
        yield
    except (UsageError, FemContactError) as error:
        # All processes refuse alike, and before they would wait for each other.
        if comm.rank:
            # The first one's exit code is that of all; they wait for each other at the end.
            raise typer.Exit(0) from None
        raise (RunFailed if isinstance(error, NotConverged) else UsageError)(str(error)) from None
    except BaseException:
        if comm.size > 1:
            sys.excepthook(*sys.exc_info())
            sys.stderr.flush()
            comm.Abort(1)
        raise


def _solves(scene: Scene) -> list[Press]:
    # No process has the whole surface: what is checked are the moments of its C(q).
    problem = replace(realise(scene), drawn=False)
    check_scene(scene, problem)
    if problem.load.held:
        raise UsageError(f"load.{problem.load.key}: --mpi presses with a load; give a pressure or a force")
    for effect in scene.effects:
        if effect.slot in ("gap law", "boundary") or type(effect).shaped is not Effect.shaped:
            raise UsageError(f"effect {effect.kind!r}: is not solved with --mpi; leave one of them out")
        effect.check_solver("bem --mpi", key=f"effect {effect.kind!r}")
    if "bem" not in scene.methods.solvers:
        raise UsageError("--mpi: solves by boundary elements; list methods.bem")
    if scene.methods.options("bem").under_resolved:
        raise UsageError("methods.bem.under_resolved: not with --mpi; leave it out, with its grids")
    grids = scene.methods.options("bem").grids
    solves = (solve for solve in solves_of(scene, problem) if solve.method == "bem" and solve.is_own)
    return [solve for solve in solves if solve.grid in grids]


def _solved(solve: Press, folder: Path, comm: Any) -> dict[str, Any]:
    path = folder / f"{solve.key}.h5"
    stored: dict[str, Any] | None = comm.bcast(_finished(solve, path) if comm.rank == 0 else None)
    if stored is not None:
        return stored
    rough = solve.problem.surface
    # Every process reads a measured surface; of a random one each makes its slab.
    if isinstance(rough, FileSurface):
        surface = bem.SlabSurface.of(solve.height_field(), comm)
    else:
        drawn = waves_drawn(rough, solve.problem.realisation)
        surface = bem.SlabSurface.random(shape=solve.grid, comm=comm, **drawn)
    model = ContactModel.filled(solve.problem.elastic, solve.effects)
    (load,) = solve.problem.load.values
    if solve.problem.load.key == "reduced_pressure" and not isinstance(rough, FileSurface):
        load *= model.solid.contact_modulus * surface.rms_gradient
    else:
        load = solve.problem.pressure
    result = bem.solve(
        surface,
        model.felt_response,
        mean_pressure=load,
        pressure_bound=model.pressure_bound,
        comm=comm,
        **dict[str, Any](solve.settings),
    ).checked()
    dx, dy = surface.spacing
    areas = result.areas(subcell=not solve.effects and abs(dx / dy - 1) <= 0.05)
    cost = result.contact.cost
    row = {
        "grid": list(solve.grid),
        "areas": asdict(areas),
        "mean_pressure": load,
        "pairs": cost.fft_pairs,
        "seconds": cost.wall_seconds,
        "peak_bytes": float(surface.slabs.gathered(cost.peak_bytes).max()),
        "processes": comm.size,
    }
    if comm.rank == 0:
        folder.mkdir(parents=True, exist_ok=True)
    result.write(path, about={"recipe": solve.recipe_text, "row": json.dumps(row)})
    if comm.rank == 0:
        write_record(path.with_suffix(".json"), {"recipe": solve.recipe_text, "row": row})
    return row


def _finished(solve: Press, path: Path) -> dict[str, Any] | None:
    record = path.with_suffix(".json")
    try:
        stored = read_record(record)
        if path.exists() and stored["recipe"] == solve.recipe_text:
            return dict(stored["row"])
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as damage:
        say(f"{record}: damaged ({damage}); computed again")
    return None


def _print(
    rows: list[dict[str, Any]], folder: Path, processes: int, *, resolved: Sequence[bool], as_json: bool
) -> None:
    areas = [ContactAreas(**row["areas"] | {"spacing": tuple(row["areas"]["spacing"])}) for row in rows]
    limit = limit_over([area for area, fine in zip(areas, resolved, strict=True) if fine] or areas)
    if as_json:
        print_json({"processes": processes, "grids": rows, "limit": asdict(limit)})
        return
    table = Table("grid", "A/A0 counted", "located", "pairs", "seconds", "MiB of a process", "processes")
    for row in rows:
        pixel, located = row["areas"]["pixel"], row["areas"]["subcell"]
        counted = f"{pixel:.6g}", "-" if located is None else f"{located:.6g}"
        spent = f"{row['pairs']:.1f}", f"{row['seconds']:.2f}", f"{row['peak_bytes'] / 2**20:.4g}"
        table.add_row("{} x {}".format(*row["grid"]), *counted, *spent, str(row["processes"]))
    show(table)
    claim = limit.doubt or f"{limit.value:.6g} +- {2 * limit.uncertainty:.2g} (95 %)"
    show(f"Limit of A/A0 over these grids: {claim}. Boundary elements alone, one surface, unshifted.")
    show(f"Fields: {folder}/*.h5")
