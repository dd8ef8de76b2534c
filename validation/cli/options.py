"""What the commands of `fem-contact` share: options, printing, and how they stop."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.errors import SceneError, UsageError

if TYPE_CHECKING:
    from validation.execution.running import Execution
    from validation.execution.solve import Solve
    from validation.execution.store import Store
    from validation.scenes.scene import RunOptions

__all__ = [
    "WIDE",
    "AccuracyOption",
    "DryRunOption",
    "JsonOption",
    "MemoryOption",
    "MpiOption",
    "OutputOption",
    "PicturesOption",
    "QuietOption",
    "ReportOption",
    "SceneArgument",
    "SchedulerOption",
    "SetOption",
    "StoreOption",
    "TimeLimitOption",
    "WorkersOption",
    "chosen_accuracy",
    "chosen_execution",
    "naming",
    "print_plan",
    "say",
    "show",
    "stopping_cleanly",
    "terminal_width",
]


def _scene_names(incomplete: str) -> list[str]:
    """Complete the name of a scene: built-in ones, and TOML files of the folder."""
    from validation.scenes.scene import builtin_scenes

    files = [str(path) for path in Path().glob("*.toml")]
    return [name for name in (*builtin_scenes(), *files) if name.startswith(incomplete)]


def _key_names(incomplete: str) -> list[str]:
    """Complete a key of a scene."""
    from validation.scenes.keys import scene_keys

    return [f"{key}=" for key in scene_keys({}) if key.startswith(incomplete)]


SceneArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCENE", help="A built-in scene by name, or a TOML file.", autocompletion=_scene_names
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        autocompletion=_key_names,
        help="Set a key of the scene, e.g. solid.young='2 GPa' or sweep.seed=[7,8]; may be given "
        "several times.",
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for scripts instead of tables.")]
OutputOption = Annotated[
    Path | None, typer.Option("--output", "-o", help="Results folder. Default: results/<name>.")
]
StoreOption = Annotated[
    Path | None,
    typer.Option(
        "--store",
        envvar="FEM_CONTACT_STORE",
        help="Folder of finished solves, which runs and studies may share.",
    ),
]
WorkersOption = Annotated[
    int | None,
    typer.Option(
        "--workers", "-w", min=1, help="Local processes of one thread each. Default: none but this one."
    ),
]
SchedulerOption = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        envvar="FEM_CONTACT_SCHEDULER",
        help="Dask scheduler to run on, e.g. tcp://host:8786; one that you trust.",
    ),
]
MemoryOption = Annotated[
    str | None,
    typer.Option("--memory", help='Memory for all solves together, e.g. "4 GiB". Default: what is free.'),
]
MpiOption = Annotated[
    bool,
    typer.Option(
        "--mpi",
        help="Under mpiexec: boundary elements alone, each solve shared out over all processes, into "
        "results/NAME/mpi.",
    ),
]
AccuracyOption = Annotated[
    str | None,
    typer.Option(
        "--accuracy",
        metavar="SHARE",
        help="Choose grids, tolerance and number of surfaces for this error of A/A0 (95 %), e.g. 1% or 0.01; "
        "results in results/NAME-accuracy.",
    ),
]
TimeLimitOption = Annotated[
    str | None,
    typer.Option("--time-limit", help='With --accuracy: what solving may take, e.g. "10 min".'),
]
DryRunOption = Annotated[
    bool, typer.Option("--dry-run", help="List the solves with predicted time and memory; do none.")
]
PicturesOption = Annotated[
    bool | None,
    typer.Option(
        "--pictures/--no-pictures",
        help="3-D pictures in the report, which take seconds; none if not asked for.",
    ),
]
ReportOption = Annotated[
    bool,
    typer.Option(
        "--report/--no-report", help="Figures and report, which fem-contact report DIR can make later, too."
    ),
]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar; for logs.")]


@contextlib.contextmanager
def naming(scene: str) -> Iterator[None]:
    """Name the scene in a complaint about what it says."""
    try:
        yield
    except SceneError:  # names it already
        raise
    except UsageError as error:
        raise SceneError(scene, [str(error)]) from None


def chosen_execution(
    said: RunOptions, *, workers: int | None, scheduler: str | None, memory: str | None
) -> Execution:
    """Return how to run: the command line before the scene."""
    from validation.execution.running import Execution
    from validation.units import Memory, read_quantity

    limit = said.memory if memory is None else read_quantity(Memory, memory, "--memory")
    if workers is not None and scheduler is not None:
        raise UsageError(
            f"--workers = {workers}: not together with --scheduler, which has workers of its own"
        )
    if workers is None and scheduler is None:
        workers = said.workers
    return Execution(workers=workers or 1, scheduler=scheduler, memory=None if limit is None else int(limit))


def chosen_accuracy(
    accuracy: str | None, *, time_limit: str | None, dry_run: bool, execution: Execution
) -> dict[str, Any] | None:
    """Return what is asked of `run_accurate`, or None if no accuracy is asked for."""
    if accuracy is None:
        if time_limit is not None:
            raise UsageError(f"--time-limit = {time_limit!r}: belongs to --accuracy, which is not given")
        return None
    from validation.comparison.accuracy import parse_accuracy
    from validation.units import Duration, read_quantity

    target = parse_accuracy(accuracy)
    if dry_run:
        raise UsageError("--dry-run: not together with --accuracy, whose grids are chosen from first solves")
    if execution.scheduler is not None:
        raise UsageError("--scheduler: not together with --accuracy, which measures this machine")
    seconds = None if time_limit is None else read_quantity(Duration, time_limit, "--time-limit")
    return {"target": target, "time_limit": seconds}


@contextlib.contextmanager
def stopping_cleanly() -> Iterator[None]:
    """Turn Ctrl-C into a sentence and exit code 130."""
    try:
        yield
    except KeyboardInterrupt:
        say("interrupted; every finished solve is stored, and the same command continues after it")
        raise typer.Exit(130) from None


def print_plan(solves: Sequence[Solve], store: Store, *, as_json: bool) -> None:
    """Print every solve with its predicted cost and whether it is finished."""
    from rich.table import Table

    from validation.execution.cost import transform_seconds

    pair = transform_seconds()
    rows: list[dict[str, Any]] = []
    for solve in solves:
        cost = solve.predict(pair_seconds=pair)
        sizes = {"seconds": cost.seconds, "peak_bytes": cost.peak_bytes, "unknowns": cost.unknowns}
        stored = os.path.exists(store.path(solve))
        rows.append({"key": solve.key, "solve": solve.describe(), **sizes, "stored": stored})
    if as_json:
        typer.echo(json.dumps(rows, indent=2))
        return
    table = Table(title="What would be solved")
    for column in ("solve", "seconds", "peak MiB", "unknowns", "stored"):
        table.add_column(column, justify="left" if column == "solve" else "right")
    for row in rows:
        numbers = f"{row['seconds']:.2g}", f"{row['peak_bytes'] / 2**20:.3g}", f"{row['unknowns']:,}"
        table.add_row(row["solve"], *numbers, "yes" if row["stored"] else "no")
    show(table)
    todo = [row for row in rows if not row["stored"]]
    seconds = sum(row["seconds"] for row in todo)
    largest = max((row["peak_bytes"] for row in todo), default=0) / 2**20
    show(
        f"{len(todo)} of {len(rows)} solves are to be done: about {seconds:.2g} s one "
        f"after the other, {largest:.3g} MiB for the largest (meant to be right within a factor of 2)."
    )


#: Columns of a log or a pipe, which have no width of their own.
WIDE = 160


def show(what: Any) -> None:
    """Print a text, what is dangerous to a terminal made harmless, or a table."""
    from rich.console import Console

    from validation.errors import harmless

    # Without markup: a title such as "[/]" is a title. A table must not be squeezed to 80 columns in a log.
    width, text = None if terminal_width() else WIDE, isinstance(what, str)
    Console(highlight=False, markup=False, width=width, soft_wrap=text).print(
        harmless(what) if text else what
    )


def terminal_width() -> int | None:
    """Columns of the terminal; None for a log file or a pipe, which have no width."""
    from rich.console import Console

    console = Console()
    return console.width if console.is_terminal else None


def say(message: Exception | str, *, prefix: str = "fem-contact: ") -> None:
    """Print a line for the user on stderr."""
    from validation.errors import harmless

    typer.echo(harmless(f"{prefix}{message}"), err=True)
