"""The commands `fem-contact run`, `explain`, `calibrate` and `report`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Annotated, Any

import typer

from validation.cli import options
from validation.errors import UsageError

if TYPE_CHECKING:
    from validation.execution.solve import Solve
    from validation.scenes.scene import Scene
    from validation.scenes.sweep import Sweep


def run(
    scene: options.SceneArgument = "quickstart",
    settings: options.SetOption = None,
    output: options.OutputOption = None,
    store: options.StoreOption = None,
    workers: options.WorkersOption = None,
    scheduler: options.SchedulerOption = None,
    memory: options.MemoryOption = None,
    dry_run: options.DryRunOption = False,
    accuracy: options.AccuracyOption = None,
    time_limit: options.TimeLimitOption = None,
    pictures: options.PicturesOption = None,
    with_report: options.ReportOption = True,
    quiet: options.QuietOption = False,
    as_json: options.JsonOption = False,
    mpi: options.MpiOption = False,
) -> None:
    """Press one scene: solve, compare with the theory, write a report.

    Solves that are finished are used again: an interrupted run continues where it stopped. A scene with a
    table 'sweep' is run at every value of the keys it lists, into one report. With --accuracy the command
    chooses grids, tolerance and number of surfaces. Options of where and how to run may also stand in the
    scene, in its table 'run'.
    """
    from validation.execution.bench import Bench
    from validation.scenes.sweep import Sweep, load_asked

    loaded = load_asked(scene, settings or (), grids_chosen=accuracy is not None)
    how = loaded.run
    folder, store_folder = _folders(loaded, output, store, accurate=accuracy is not None)
    alone: dict[str, Any] = {"--accuracy": accuracy, "--time-limit": time_limit}
    if mpi:
        from validation.cli.parallel import run_parallel

        unfit = {"--workers": workers, "--scheduler": scheduler, "--dry-run": dry_run, **alone}
        run_parallel(loaded, folder / "mpi", as_json=as_json, unfit=unfit)
        return
    execution = options.chosen_execution(how, workers=workers, scheduler=scheduler, memory=memory)
    given = [flag for flag, value in {**alone, "--pictures": pictures}.items() if value]
    if given and isinstance(loaded, Sweep):
        raise UsageError(
            f"{given[0]}: not together with the table [sweep] of {scene}; run one scene of it by --set"
        )
    chosen = options.chosen_accuracy(accuracy, time_limit=time_limit, dry_run=dry_run, execution=execution)
    with options.naming(scene):
        drawn = with_report and (how.pictures if pictures is None else pictures)
        solves, solve = _prepared(loaded, folder, chosen=chosen, pictures=drawn)
    if dry_run:
        options.print_plan(solves(), Bench.at(store_folder).store, as_json=as_json)
        return
    from validation.cli.results import Bar, print_outputs

    with Bar(quiet=quiet or how.quiet or as_json) as bar:
        bench = Bench.at(store_folder, execution=execution, progress=bar)
        outputs = solve(bench=bench, report=with_report)
    line = f"Solves done: {outputs.solved}, found finished: {outputs.reused}. Written:"
    print_outputs(outputs, as_json=as_json, done=line)
    outputs.check()


def _prepared(
    loaded: Scene | Sweep, folder: Path, *, chosen: dict[str, Any] | None, pictures: bool
) -> tuple[Callable[[], Sequence[Solve]], Callable[..., Any]]:
    from validation.comparison.accuracy import run_accurate
    from validation.comparison.explain import problems_of, solves_of_sweep
    from validation.comparison.run import run_scene, run_sweep
    from validation.execution.press import run_solves
    from validation.scenes.checks import check_scene
    from validation.scenes.problem import realise
    from validation.scenes.sweep import Sweep

    if isinstance(loaded, Sweep):
        cases = problems_of(loaded)
        return partial(solves_of_sweep, loaded, cases), partial(run_sweep, loaded, folder, cases=cases)
    problem = realise(loaded)
    check_scene(loaded, problem)
    run = partial(run_scene, problem=problem) if chosen is None else partial(run_accurate, **chosen)
    return partial(run_solves, loaded, problem), partial(run, loaded, folder, pictures=pictures)


def _folders(
    scene: Scene | Sweep, output: Path | None, store: Path | None, *, accurate: bool
) -> tuple[Path, Path]:
    """Return the folders of results and of solves: the command line goes before the scene."""
    from validation.scenes.tables import not_led_out

    how, results = scene.run, Path("results")
    plain = output or how.folder("output") or not_led_out(results / scene.name, of=results, option="--output")
    folder = plain
    if accurate and not (output or how.output):
        # Beside the results of a plain run, whose solves it shares.
        folder = not_led_out(plain.with_name(f"{plain.name}-accuracy"), of=results, option="--output")
    return folder, store or how.folder("store") or not_led_out(plain / "solves", of=plain, option="--store")


def explain(
    scene: options.SceneArgument = "quickstart",
    settings: options.SetOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Say what a scene would run, at what cost, and what it leaves out."""
    from validation.comparison.explain import explain as explain_scene
    from validation.comparison.explain import explain_sweep
    from validation.scenes.sweep import Sweep, load_asked

    loaded = load_asked(scene, settings or ())
    with options.naming(scene):
        explanation = explain_sweep(loaded) if isinstance(loaded, Sweep) else explain_scene(loaded)
    if as_json:
        options.print_json(explanation.summary())
    else:
        for part in explanation.parts():
            options.show(part)


def calibrate(
    points: Annotated[
        int, typer.Option("--points", metavar="N", min=32, help="Along a side of the grid.")
    ] = 256,
    as_json: options.JsonOption = False,
) -> None:
    """Measure what effects cost on this machine, for better predictions.

    explain and --dry-run predict from it.
    """
    from validation.execution.calibration import cache_file
    from validation.execution.calibration import calibrate as measure

    measured = measure(points=points, tell=None if as_json else typer.echo)
    if as_json:
        options.print_json({"factors": dict(measured.factors), "source": measured.source})
    else:
        typer.echo(f"Kept in {cache_file()}")


def report(
    folder: options.FolderArgument,
    pictures: options.PicturesOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Write the report of finished results again, from what is stored."""
    from validation.cli.results import under_way
    from validation.execution.results import check_results, record_of, show

    check_results(folder)
    kind = str(record_of(folder).get("kind"))
    with under_way("drawing figures, writing the report", quiet=as_json):
        if kind in _PAGES:
            files = show(folder, resolve_name(_PAGES[kind])).files
        else:
            from validation.comparison.run import report_scene

            files = report_scene(folder, pictures=pictures).files
    if as_json:
        options.print_json(list(files))
    else:
        typer.echo("\n".join(f"  {path}" for path in files))


#: Who makes the page of what is no scene.
_PAGES = {
    "claims": "validation.cases._result:claims_page",
    "paper": "validation.paper.reproduce:paper_page",
    "study": "validation.studies._outputs:study_page",
}
