"""The command `fem-contact`."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.cli.audit import audit
from validation.cli.challenge import challenge_app
from validation.cli.compare import compare
from validation.cli.options import (
    AccuracyOption,
    DryRunOption,
    JsonOption,
    MemoryOption,
    MpiOption,
    OutputOption,
    PicturesOption,
    QuietOption,
    ReportOption,
    SceneArgument,
    SchedulerOption,
    SetOption,
    StoreOption,
    TimeLimitOption,
    WorkersOption,
    chosen_accuracy,
    chosen_execution,
    naming,
    print_plan,
    say,
    show,
    stopping_cleanly,
)
from validation.cli.reference import reference
from validation.cli.refusals import refusals_in_words
from validation.cli.store import store_app
from validation.cli.surface import surface_app
from validation.cli.validate import reproduce, validate
from validation.errors import RunFailed, UsageError

if TYPE_CHECKING:
    from validation.execution.solve import Solve
    from validation.scenes.scene import Scene
    from validation.scenes.sweep import Sweep
    from validation.studies import Study

__all__ = ["app", "main"]

app = typer.Typer(
    name="fem-contact",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Press a rough surface against an elastic solid by two solvers and compare with Persson's theory.",
    epilog="Exit codes: 0 done; 1 a solve or a check failed; 2 a mistake in the request, nothing was "
    "computed; "
    "130 interrupted. Shell completion: fem-contact --install-completion.",
)
scenes_app = typer.Typer(no_args_is_help=True, help="The scenes that come with the package.")
app.add_typer(scenes_app, name="scenes")
app.add_typer(surface_app, name="surface")
app.add_typer(store_app, name="store")
app.command(epilog="Examples: fem-contact audit results/quickstart  |  fem-contact audit mine --list")(audit)
app.command(epilog="Example: fem-contact reference --hurst 0.8 --bandwidth 16 --pressure 0.05")(reference)
app.command(epilog="Example: fem-contact compare results/quickstart results/mine")(compare)
app.command(
    epilog="Examples: fem-contact validate --quick  |  fem-contact validate hertz westergaard  |  "
    "fem-contact validate --method my_module:solve --method bem"
)(validate)
app.command(epilog="Examples: fem-contact reproduce  |  fem-contact reproduce --no-figures --json")(reproduce)
app.add_typer(challenge_app, name="challenge")


@app.command(
    epilog="Examples: fem-contact run quickstart  |  fem-contact run mine.toml --workers 2 --store "
    "results/solves"
    "  |  fem-contact run mine.toml --dry-run  |  fem-contact run mine.toml --accuracy 1%"
    "  |  fem-contact run mine.toml --set surface.hurst=0.7 --set hardness='3 GPa'"
)
def run(
    scene: SceneArgument = "quickstart",
    settings: SetOption = None,
    output: OutputOption = None,
    store: StoreOption = None,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    memory: MemoryOption = None,
    dry_run: DryRunOption = False,
    accuracy: AccuracyOption = None,
    time_limit: TimeLimitOption = None,
    pictures: PicturesOption = None,
    with_report: ReportOption = True,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
    mpi: MpiOption = False,
) -> None:
    """Run a scene: solve, compare, write table, fields and report.

    Finished solves in the store are used again, so an interrupted run continues where it stopped. Options of
    where and how to run may also stand in the scene, in its table 'run'. A scene with a table 'sweep' is run
    at every value of the keys it lists, into one dataset and one report. With --accuracy, grids, tolerance
    and number of surfaces are chosen instead of read from the scene, and results go to
    results/NAME-accuracy.
    """
    from validation.cli.progress import Bar
    from validation.cli.results import print_page
    from validation.execution.store import Store
    from validation.scenes.sweep import Sweep, load_asked

    loaded = load_asked(scene, settings or (), grids_chosen=accuracy is not None)
    said = loaded.run
    folder, store_folder = _folders(loaded, output, store, accurate=accuracy is not None)
    alone: dict[str, Any] = {"--accuracy": accuracy, "--time-limit": time_limit}
    if mpi:
        from validation.cli.parallel import run_parallel

        unfit = {"--workers": workers, "--scheduler": scheduler, "--dry-run": dry_run, **alone}
        run_parallel(loaded, folder / "mpi", as_json=as_json, unfit=unfit)
        return
    execution = chosen_execution(said, workers=workers, scheduler=scheduler, memory=memory)
    for flag, value in {**alone, "--pictures": pictures}.items():
        if value and isinstance(loaded, Sweep):
            raise UsageError(
                f"{flag}: not together with the table [sweep] of {scene}; run one scene of it by --set"
            )
    chosen = chosen_accuracy(accuracy, time_limit=time_limit, dry_run=dry_run, execution=execution)
    with naming(scene):
        drawn = with_report and (said.pictures if pictures is None else pictures)
        solves, solve = _prepared(loaded, folder, chosen=chosen, pictures=drawn)
    if dry_run:
        print_plan(solves(), Store(folder=store_folder), as_json=as_json)
        return
    with stopping_cleanly(), Bar(quiet=quiet or said.quiet or as_json) as bar:
        done = solve(progress=bar, execution=execution, store_folder=store_folder, report=with_report)
    outputs, reached = getattr(done, "outputs", done), getattr(done, "reached", None)
    if as_json:
        typer.echo(json.dumps(outputs.page.summary, indent=2))
    else:
        solved, reused = (
            (outputs.solved, outputs.reused) if reached is None else (reached.solves, reached.reused)
        )
        words = f"{solved} solves done, {reused} found finished. Written:"
        print_page(
            outputs.page, outputs.files, more=tuple(reached.sentences()) if reached else (), done=words
        )
    outputs.check()


def _prepared(
    loaded: Scene | Sweep, folder: Path, *, chosen: dict[str, Any] | None, pictures: bool
) -> tuple[Callable[[], Sequence[Solve]], Callable[..., Any]]:
    """Check what is asked, and return what lists its solves and what does them."""
    from validation.comparison.accuracy import run_accurate
    from validation.comparison.run import run_scene
    from validation.comparison.sweep import problems_of, run_sweep, solves_of_sweep
    from validation.execution.press import solves_of
    from validation.scenes.checks import check_scene
    from validation.scenes.problem import realise
    from validation.scenes.sweep import Sweep

    if isinstance(loaded, Sweep):
        cases = problems_of(loaded)
        return partial(solves_of_sweep, loaded, cases), partial(run_sweep, loaded, folder, cases=cases)
    problem = realise(loaded)
    check_scene(loaded, problem)
    run_one: Callable[..., Any] = partial(run_scene, problem=problem)
    if chosen is not None:
        run_one = partial(run_accurate, **chosen)
    return partial(solves_of, loaded, problem), partial(run_one, loaded, folder, pictures=pictures)


def _folders(
    asked: Scene | Sweep, output: Path | None, store: Path | None, *, accurate: bool
) -> tuple[Path, Path]:
    """Return the folders of results and of solves: the command line goes before the scene."""
    from validation.scenes.run_options import not_led_out

    said, results = asked.run, Path("results")
    plain = (
        output or said.folder("output") or not_led_out(results / asked.name, of=results, option="--output")
    )
    folder = plain
    if accurate and not (output or said.output):
        # Beside the results of a plain run, whose solves it shares.
        folder = not_led_out(plain.with_name(f"{plain.name}-accuracy"), of=results, option="--output")
    return folder, store or said.folder("store") or not_led_out(plain / "solves", of=plain, option="--store")


def _study_names(incomplete: str) -> list[str]:
    """Complete the name of a study."""
    from validation.studies import studies

    return [name for name in studies() if name.startswith(incomplete)]


@app.command(
    context_settings={"allow_extra_args": True, "ignore_unknown_options": True},
    add_help_option=False,
    epilog="Examples: fem-contact study --list  |  fem-contact study area --seed 3 --surfaces 3 "
    "--grids 128,192 --workers 2  |  fem-contact study pressure mine.toml --set poisson=0.4",
)
def study(
    context: typer.Context,
    name: Annotated[
        str | None,
        typer.Argument(metavar="NAME", help="A study; see --list.", autocompletion=_study_names),
    ] = None,
    list_all: Annotated[bool, typer.Option("--list", help="Name the studies and their questions.")] = False,
    scene: Annotated[
        str | None, typer.Option("--scene", help="Scene that a study is asked about; or after NAME.")
    ] = None,
    settings: SetOption = None,
    output: OutputOption = None,
    store: StoreOption = None,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    memory: MemoryOption = None,
    dry_run: DryRunOption = False,
    with_report: ReportOption = True,
    quiet: QuietOption = False,
    as_json: JsonOption = False,
    wants_help: Annotated[
        bool, typer.Option("--help", "-h", help="Show this; after a NAME, the options of that study.")
    ] = False,
) -> None:
    """Run a study: many independent solves, one dataset, figures and a report.

    Whatever follows as --option VALUE is an option of the study, see fem-contact study NAME --help. With a
    SCENE after NAME the surface, solid, load, effects and grids are those of the scene. All studies keep
    their solves in results/solves, so that they share them, unless --store says otherwise.
    """
    from validation.cli.progress import Bar
    from validation.cli.results import print_page
    from validation.execution.bench import DEFAULT_STORE, Bench, PlannedOnly
    from validation.execution.store import Store
    from validation.files import prepare_folder
    from validation.scenes.scene import RunOptions
    from validation.studies import find_study, studies
    from validation.studies._outputs import run_study

    if wants_help:
        _help_study(context, name)
        return
    if list_all or name is None:
        _list_studies(list(studies().values()), as_json=as_json)
        return
    found = find_study(name)
    extra = list(context.args)
    if extra and not extra[0].startswith("-") and scene is None:
        scene = extra.pop(0)
    loaded = _scene_of_study(scene, settings or ())
    options = found.parse(extra, scene=loaded)
    said = RunOptions() if loaded is None else loaded.run
    execution = chosen_execution(said, workers=workers, scheduler=scheduler, memory=memory)
    folder, store_folder = (
        output or Path("results") / (name if loaded is None else f"{name}-{loaded.name}"),
        store or said.folder("store") or DEFAULT_STORE,
    )
    if dry_run:
        try:
            found.compute(options, bench=Bench(store=Store(folder=store_folder), plan_only=True))
        except PlannedOnly as plan:
            print_plan(plan.solves, plan.store, as_json=as_json)
        return
    with stopping_cleanly(), Bar(quiet=quiet or said.quiet or as_json) as bar:
        bench = Bench(
            store=Store(folder=store_folder),
            execution=execution,
            progress=bar,
        )
        outputs = run_study(found, options, prepare_folder(folder), bench=bench, report=with_report)
    if as_json:
        typer.echo(json.dumps(outputs.data.to_dict(), indent=2, default=str))
        return
    print_page(outputs.page, outputs.files)


def _scene_of_study(scene: str | None, settings: Sequence[str]) -> Scene | None:
    """Read the one scene that a study is asked about."""
    from validation.scenes.sweep import Sweep, load_asked

    if scene is None:
        if settings:
            raise UsageError(f"--set {settings[0]}: sets a key of a scene; name one after the study")
        return None
    loaded = load_asked(scene, settings)
    if isinstance(loaded, Sweep):
        raise UsageError(f"{scene}: [sweep] makes it many scenes; a study is asked about one")
    return loaded


@app.command(epilog="Example: fem-contact explain quickstart")
def explain(
    scene: SceneArgument = "quickstart", settings: SetOption = None, as_json: JsonOption = False
) -> None:
    """Say what a scene would run, on which grids, at what cost, and what it leaves out. Solves nothing."""
    from validation.comparison.explain import explain as explain_scene
    from validation.comparison.sweep import explain_sweep
    from validation.scenes.sweep import Sweep, load_asked

    loaded = load_asked(scene, settings or ())
    with naming(scene):
        explanation = explain_sweep(loaded) if isinstance(loaded, Sweep) else explain_scene(loaded)
    if as_json:
        typer.echo(json.dumps(explanation.summary(), indent=2))
    else:
        for part in explanation.parts():
            show(part)


@app.command(epilog="Example: fem-contact calibrate")
def calibrate(
    points: Annotated[int, typer.Option("--points", min=32, help="Points along a side.")] = 256,
    as_json: JsonOption = False,
) -> None:
    """Measure what each effect costs on this machine; explain and --dry-run then predict from it."""
    from validation.execution.calibration import cache_file
    from validation.execution.calibration import calibrate as measure

    with stopping_cleanly():
        found = measure(points=points, tell=None if as_json else typer.echo)
    if as_json:
        typer.echo(json.dumps({"factors": dict(found.factors), "source": found.source}, indent=2))
    else:
        typer.echo(f"Kept in {cache_file()}")


@app.command(epilog="Example: fem-contact report results/quickstart")
def report(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Results folder of a run, a sweep or a study.")
    ],
    pictures: PicturesOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write the report of finished results again, from what is stored alone. Solves nothing."""
    from validation.comparison.run import report_scene
    from validation.execution.results import check_results, holds_result
    from validation.studies._outputs import is_study, report_study

    check_results(folder)
    if holds_result(folder, "claims"):
        from validation.cases._result import report_claims

        files = report_claims(folder)[1]
    elif holds_result(folder, "paper"):
        from validation.paper.reproduce import report as report_paper

        files = report_paper(folder)[1]
    elif is_study(folder):
        files = report_study(folder).files
    else:
        files = report_scene(folder, pictures=pictures).files
    if as_json:
        typer.echo(json.dumps([str(path) for path in files], indent=2))
    else:
        typer.echo("\n".join(f"  {path}" for path in files))


@scenes_app.command("list", epilog="Example: fem-contact scenes list")
def list_scenes(as_json: JsonOption = False) -> None:
    """Name the built-in scenes and what each shows."""
    from validation.scenes.scene import builtin_scenes, load_scene

    titles = {name: load_scene(name).title for name in builtin_scenes()}
    if as_json:
        typer.echo(json.dumps(titles, indent=2))
        return
    for name, title in titles.items():
        typer.echo(f"{name:20s} {title}")


@scenes_app.command("keys", epilog="Examples: fem-contact scenes keys  |  fem-contact scenes keys load")
def list_keys(
    word: Annotated[str, typer.Argument(metavar="WORD", help="Part of a key or of its meaning.")] = "",
) -> None:
    """List the keys that a scene may have: example, meaning, unit, default. As a page: docs/scene.md."""
    from validation.scenes.keys import key_lines

    for line in key_lines(word):
        show(line)


@scenes_app.command("show", epilog="Example: fem-contact scenes show quickstart")
def show_scene(scene: SceneArgument) -> None:
    """Print the text of a scene."""
    from validation.scenes.scene import scene_text

    typer.echo(scene_text(scene)[0], nl=False)


@scenes_app.command("copy", epilog="Example: fem-contact scenes copy quickstart mine.toml")
def copy_scene(
    scene: SceneArgument,
    target: Annotated[Path, typer.Argument(metavar="FILE", help="TOML file to write.")],
) -> None:
    """Copy a scene to a file of your own, to be changed; it takes the name of its file."""
    from validation.scenes.scene import scene_text

    text = _named_after(scene_text(scene)[0], target)
    try:
        with target.open("x", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise UsageError(f"{target}: not written: {error.strerror}") from None
    typer.echo(f"{target}: a copy of {scene}; run it with: fem-contact run {target}")


def _named_after(text: str, target: Path) -> str:
    """Take the name out of a scene's text: its file names it, and its results go to a folder of their own."""
    head, table, rest = text.partition("\n[")
    stem = re.sub(r"[^A-Za-z0-9._-]+", "-", target.stem).strip("-._")
    # A file whose name cannot name a folder is named in its text.
    name = "" if stem == target.stem else f'name = "{stem or "copy"}"\n'
    return re.sub(r"(?m)^name\s*=.*\n?", lambda _: name, head, count=1) + table + rest


def _list_studies(known: list[Study], *, as_json: bool) -> None:
    if as_json:
        typer.echo(json.dumps({study.name: list(study.options.flags()) for study in known}, indent=2))
        return
    for study in known:
        typer.echo(study.help_lines()[0])
    typer.echo("\nOptions of one: fem-contact study NAME --help")


def _help_study(context: typer.Context, name: str | None) -> None:
    """Print the options of one study, or the help of the command."""
    from validation.studies import find_study

    if name is None:
        typer.echo(context.get_help())
        return
    typer.echo("\n".join(find_study(name).help_lines()))
    typer.echo("\nOptions of all studies, where and how they run: fem-contact study --help")


def main() -> None:
    """Run the command line: a user's mistake is one line on stderr and exit code 2, never a traceback."""
    with refusals_in_words():
        try:
            app()
        except UsageError as error:
            say(error)
            sys.exit(2)
        except RunFailed as error:
            say(error)
            sys.exit(1)


if __name__ == "__main__":
    main()
