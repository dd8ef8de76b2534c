"""What the commands of `fem-contact` share: options, printing, and how they stop."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.errors import SceneError, UsageError, harmless

if TYPE_CHECKING:
    from validation.execution.bench import Execution
    from validation.execution.solve import Solve
    from validation.execution.store import Store
    from validation.scenes.tables import RunOptions


def scene_names() -> list[str]:
    """Names of scenes: built-in ones, and TOML files of the folder."""
    from validation.scenes.scene import builtin_scenes

    return [*builtin_scenes(), *map(str, Path().glob("*.toml"))]


def key_names() -> list[str]:
    """Keys of a scene."""
    from validation.scenes.keys import scene_keys

    return [f"{key}=" for key in scene_keys({})]


def named_by(listing: str) -> Callable[[], list[str]]:
    """Return what completes a name that a ``module:function`` lists; it is imported when that is asked."""
    return lambda: list(resolve_name(listing)())


def examples(*lines: str) -> str:
    """Return what stands below a help text: each example on a line of its own."""
    return "\n\n".join(("Examples:", *lines))


def option(words: str, *names: str, metavar: str = "", **more: Any) -> Any:
    """Return an option; without a metavar a flag. Types and defaults would leave no room for words."""
    return typer.Option(*names, help=words, metavar=metavar, show_default=False, **more)


def argument(metavar: str, words: str, **more: Any) -> Any:
    """Return an argument, as it is called in the help, and what it is."""
    return typer.Argument(metavar=metavar, help=words, **more)


_HOW: Any = {"rich_help_panel": "Where and how to run"}
_FILES: Any = {"rich_help_panel": "What is written"}

SceneArgument = Annotated[
    str, argument("SCENE", "A built-in scene, or a TOML file.", autocompletion=scene_names)
]
FolderArgument = Annotated[Path, argument("DIR", "Results folder of a run, a sweep or a study.")]
SetOption = Annotated[
    list[str] | None,
    option(
        "Set a key of the scene, such as solid.young='2 GPa'. May be given several times; scenes keys "
        "lists the keys.",
        "--set",
        metavar="KEY=VALUE",
        autocompletion=key_names,
    ),
]
JsonOption = Annotated[bool, option("Print JSON for scripts.", "--json")]
OutputOption = Annotated[
    Path | None, option("Default: a folder in results, by name.", "--output", "-o", metavar="DIR", **_FILES)
]
StoreOption = Annotated[
    Path | None,
    option(
        "Finished solves, which runs and studies may share.",
        metavar="DIR",
        envvar="FEM_CONTACT_STORE",
        **_FILES,
    ),
]
WorkersOption = Annotated[
    int | None, option("Local processes of one thread each.", "--workers", "-w", metavar="N", min=1, **_HOW)
]
SchedulerOption = Annotated[
    str | None,
    option(
        "Dask scheduler that you trust, such as tcp://host:8786.",
        metavar="URL",
        envvar="FEM_CONTACT_SCHEDULER",
        **_HOW,
    ),
]
MemoryOption = Annotated[
    str | None, option('For all solves, such as "4 GiB"; else what is free.', metavar="SIZE", **_HOW)
]
MpiOption = Annotated[
    bool,
    option(
        "Under mpiexec: boundary elements alone, each solve on all processes, into results/NAME/mpi.",
        "--mpi",
        **_HOW,
    ),
]
AccuracyOption = Annotated[
    str | None,
    option(
        "Choose grids, tolerance and number of surfaces for this error of A/A0 (95 %), such as 1%; "
        "into results/NAME-accuracy.",
        metavar="SHARE",
    ),
]
TimeLimitOption = Annotated[
    str | None, option('With --accuracy: for all solves, such as "10 min".', metavar="TIME")
]
DryRunOption = Annotated[bool, option("Say what would be solved, and its cost.", "--dry-run")]
PicturesOption = Annotated[
    bool | None,
    option("3-D pictures in the report, which take seconds.", "--pictures/--no-pictures", **_FILES),
]
ReportOption = Annotated[
    bool,
    option(
        "Figures and report, or tables alone; fem-contact report DIR makes them later.",
        "--report/--no-report",
        **_FILES,
    ),
]
QuietOption = Annotated[bool, option("No progress bar.", "--quiet", "-q")]


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
    scene: RunOptions, *, workers: int | None, scheduler: str | None, memory: str | None
) -> Execution:
    """Return how to run: the command line before the scene."""
    from validation.execution.bench import Execution
    from validation.units import Memory, read_quantity

    limit = scene.memory if memory is None else read_quantity(Memory, memory, "--memory")
    usual = scene.workers if scheduler is None else 1
    memory_limit = None if limit is None else int(limit)
    return Execution(workers=workers or usual, scheduler=scheduler, memory=memory_limit)


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


#: Kinds of solves that a plan lists; the cheaper ones stand together in one line.
_MOST_GROUPS = 6


def print_plan(solves: Sequence[Solve], store: Store, *, as_json: bool) -> None:
    """Print what would be solved in a few lines, alike solves together; for scripts each one."""
    from validation.execution.solve import transform_seconds

    pair = transform_seconds()
    rows: list[dict[str, Any]] = []
    for solve in solves:
        sizes, stored = vars(solve.predict(pair_seconds=pair)), os.path.exists(store.path(solve))
        rows.append({"key": solve.key, "solve": solve.describe(), **sizes, "stored": stored})
    if as_json:
        print_json(rows)
        return
    groups: dict[str, list[dict[str, Any]]] = {}
    for row in sorted(rows, key=lambda row: -row["seconds"]):
        name = row["solve"].partition(",")[0]
        few = name in groups or len(groups) < _MOST_GROUPS
        groups.setdefault(name if few else "the cheaper ones", []).append(row)
    heads = ("solves", "stored", "seconds", "MiB")
    show(f"{'what would be solved, the dearest first':46s}" + "".join(f"{head:>8s}" for head in heads))
    for name, group in groups.items():
        stored, seconds = (sum(row[key] for row in group) for key in ("stored", "seconds"))
        largest = max(row["peak_bytes"] for row in group) / 2**20
        show(f"{name[:45]:46s}{len(group):8d}{stored:8d}{_briefly(seconds):>8s}{_briefly(largest):>8s}")
    left = [row["seconds"] for row in rows if not row["stored"]]
    show(
        f"{len(left)} of {len(rows)} solves are to be done, in about {_briefly(sum(left))} s one after the "
        "other (right within a factor of 2)."
    )


def _briefly(number: float) -> str:
    return f"{number:.2g}" if number < 100 else f"{number:.0f}"


def print_json(value: Any) -> None:
    """Print what a script reads."""
    typer.echo(json.dumps(value, indent=2, default=str))


#: Columns of a log or a pipe, which have no width of their own.
WIDE = 160


def show(what: Any) -> None:
    """Print a text, what is dangerous to a terminal made harmless, or a table."""
    from rich.console import Console

    # Without markup: a title such as "[/]" is a title. A table must not be squeezed to 80 columns in a log.
    width, text = None if terminal_width() else WIDE, isinstance(what, str)
    console = Console(highlight=False, markup=False, width=width, soft_wrap=text)
    console.print(harmless(what) if text else what)


def terminal_width() -> int | None:
    """Columns of the terminal; None for a log file or a pipe, which have no width."""
    from rich.console import Console

    console = Console()
    return console.width if console.is_terminal else None


def say(message: Exception | str, *, prefix: str = "fem-contact: ") -> None:
    """Print a line for the user on stderr."""
    typer.echo(harmless(f"{prefix}{message}"), err=True)
