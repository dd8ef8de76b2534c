"""The command `fem-contact`."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.errors import RunFailed, UsageError

if TYPE_CHECKING:
    from validation.jobs import Job

__all__ = ["app", "main"]

app = typer.Typer(
    name="fem-contact",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Press a rough surface against an elastic solid by two solvers and compare with Persson's theory.",
    epilog="Exit codes: 0 done, 1 a solve failed, 2 a mistake in the request, 130 interrupted.",
)
scenes_app = typer.Typer(no_args_is_help=True, help="The scenes that come with the package.")
app.add_typer(scenes_app, name="scenes")

SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="A built-in scene by name, or a TOML file.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for scripts instead of tables.")]


@app.command(epilog="Example: fem-contact run quickstart --output results/quickstart")
def run(
    scene: SceneArgument = "quickstart",
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Results folder. Default: results/<name of the scene>."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar; for logs.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Run a scene: solve, compare, write table, fields and report.

    Finished solves in the results folder are used again, so an interrupted run continues where it stopped.
    """
    from validation.report import console_table
    from validation.run import run_scene
    from validation.scene import load_scene

    loaded = load_scene(scene)
    folder = output or Path("results") / loaded.name
    try:
        with _Bar(quiet=quiet or as_json) as bar:
            outputs = run_scene(loaded, folder, progress=bar)
    except KeyboardInterrupt:
        _say("interrupted; every finished solve is stored, and the same command continues after it")
        raise typer.Exit(130) from None
    if as_json:
        typer.echo(json.dumps(outputs.comparison.summary(), indent=2))
        return
    _print(console_table(outputs.comparison))
    for finding in outputs.comparison.findings:
        _print(f"- {finding}")
    typer.echo(f"\n{outputs.solved} solves done, {outputs.reused} found finished. Written:")
    for path in outputs.files:
        typer.echo(f"  {path}")


@app.command(epilog="Example: fem-contact explain quickstart")
def explain(scene: SceneArgument = "quickstart", as_json: JsonOption = False) -> None:
    """Say what a scene would run, on which grids, at what cost, and what it leaves out. Solves nothing."""
    from validation.effects import explain as explain_scene
    from validation.scene import load_scene

    explanation = explain_scene(load_scene(scene))
    if as_json:
        typer.echo(json.dumps(explanation.summary(), indent=2))
    else:
        for part in explanation.parts():
            _print(part)


@scenes_app.command("list")
def list_scenes() -> None:
    """Name the built-in scenes and what each shows."""
    from validation.scene import builtin_scenes, load_scene

    for name in builtin_scenes():
        typer.echo(f"{name:20s} {load_scene(name).title}")


@scenes_app.command("show")
def show_scene(scene: SceneArgument) -> None:
    """Print the text of a scene."""
    from validation.scene import scene_text

    typer.echo(scene_text(scene)[0], nl=False)


@scenes_app.command("copy")
def copy_scene(
    scene: SceneArgument,
    target: Annotated[Path, typer.Argument(metavar="FILE", help="TOML file to write.")],
) -> None:
    """Copy a scene to a file of your own, to be changed."""
    from validation.scene import scene_text

    text = scene_text(scene)[0]
    try:
        with target.open("x", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise UsageError(f"{target}: not written: {error.strerror}") from None
    typer.echo(f"{target}: a copy of {scene}; run it with: fem-contact run {target}")


def _print(what: Any) -> None:
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=isinstance(what, str))
    # A log file or a pipe has no width: a table must not be squeezed to 80 columns there.
    if not console.is_terminal:
        console = Console(highlight=False, width=160, soft_wrap=isinstance(what, str))
    console.print(what, markup=False) if isinstance(what, str) else console.print(what)


class _Bar:
    """Progress bar over the jobs of a run, weighted by their predicted cost; prints nothing when quiet."""

    def __init__(self, *, quiet: bool) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        self._progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %"),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            disable=quiet,
        )
        self._weights: dict[str, float] = {}

    def __enter__(self) -> _Bar:
        self._progress.start()
        return self

    def __exit__(self, *exc: object) -> None:
        self._progress.stop()

    def start(self, missing: tuple[Job, ...], stored: int) -> None:
        """Show the bar over the jobs still to be done."""
        from validation.effects import predicted_cost

        self._weights = {job.key: predicted_cost(job).seconds for job in missing}
        self._task = self._progress.add_task(
            f"{stored} solves found finished", total=sum(self._weights.values())
        )

    def begin(self, job: Job) -> None:
        """Name the solve under way."""
        self._progress.update(self._task, description=job.describe())

    def done(self, job: Job) -> None:
        """Advance by the job's share."""
        self._progress.advance(self._task, self._weights[job.key])


def main() -> None:
    """Run the command line: a user's mistake is one line on stderr and exit code 2, never a traceback."""
    try:
        app()
    except UsageError as error:
        _say(error)
        sys.exit(2)
    except RunFailed as error:
        _say(error)
        sys.exit(1)


def _say(message: Exception | str) -> None:
    typer.echo(f"fem-contact: {message}", err=True)


if __name__ == "__main__":
    main()
