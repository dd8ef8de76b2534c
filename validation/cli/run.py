"""The commands `fem-contact run`, `study`, `explain`, `calibrate` and `report`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from pkgutil import resolve_name
from types import SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from validation.cli import options
from validation.errors import UsageError

if TYPE_CHECKING:
    from validation.execution.solve import Solve
    from validation.scenes.scene import Scene
    from validation.scenes.sweep import Sweep
    from validation.studies import Study


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


class StudyCommand(TyperCommand):
    """Completes the options of the study that was named, too."""

    def shell_complete(self, ctx: Any, incomplete: str) -> list[Any]:
        """Return what may stand in place of an incomplete word."""
        from validation.studies import studies

        found = super().shell_complete(ctx, incomplete)
        chosen = studies().get(ctx.params.get("name", ""))
        flags = chosen.options.flags() if chosen and incomplete else ()
        # As click has them, which typer may hold inside.
        plain = {"type": "plain", "help": ""}
        return found + [SimpleNamespace(value=f, **plain) for f in flags if f.startswith(incomplete)]


def study(
    context: typer.Context,
    name: Annotated[
        str | None,
        options.argument(
            "NAME", "A study; see --list.", autocompletion=options.named_by("validation.studies:studies")
        ),
    ] = None,
    list_all: Annotated[bool, options.option("List the studies.", "--list")] = False,
    scene: Annotated[
        str | None,
        options.option(
            "Scene that a study is asked about; or after NAME.",
            metavar="SCENE",
            autocompletion=options.scene_names,
        ),
    ] = None,
    settings: options.SetOption = None,
    output: options.OutputOption = None,
    store: options.StoreOption = None,
    workers: options.WorkersOption = None,
    scheduler: options.SchedulerOption = None,
    memory: options.MemoryOption = None,
    dry_run: options.DryRunOption = False,
    with_report: options.ReportOption = True,
    quiet: options.QuietOption = False,
    as_json: options.JsonOption = False,
    wants_help: Annotated[
        bool, options.option("Show this; after a NAME, its options.", "--help", "-h")
    ] = False,
) -> None:
    """Ask one question of many surfaces; study --list names the studies.

    Each study has options of its own, --option VALUE, which fem-contact study NAME --help lists. With a SCENE
    after NAME the surface, solid, load, effects and grids are those of the scene. All studies keep their
    solves in results/solves, so that they share them, unless --store says otherwise.
    """
    from validation.execution.bench import DEFAULT_STORE, Bench, PlannedOnly
    from validation.files import prepare_folder
    from validation.scenes.tables import RunOptions
    from validation.studies import find_study, studies
    from validation.studies._outputs import run_study

    if wants_help:
        typer.echo("\n".join(find_study(name).help_lines()) if name else context.get_help())
        if name:
            typer.echo("\nOptions of all studies, where and how they run: fem-contact study --help")
        return
    if list_all or name is None:
        _list_studies(studies(), as_json=as_json)
        return
    chosen = find_study(name)
    extra = list(context.args)
    if extra and not extra[0].startswith("-") and scene is None:
        scene = extra.pop(0)
    loaded = _scene_of_study(scene, settings or ())
    parsed = chosen.parse(extra, scene=loaded)
    how = RunOptions() if loaded is None else loaded.run
    execution = options.chosen_execution(how, workers=workers, scheduler=scheduler, memory=memory)
    folder = output or Path("results") / (name if loaded is None else f"{name}-{loaded.name}")
    store_folder = store or how.folder("store") or DEFAULT_STORE
    if dry_run:
        bench = Bench.at(store_folder, plan_only=True)
        try:
            chosen.compute(parsed, bench=bench)
        except PlannedOnly as plan:
            options.print_plan(plan.args, bench.store, as_json=as_json)
            if getattr(parsed, "ladders", False):
                options.say("--no-ladders leaves out what is solved for the budget alone", prefix="note: ")
            if "bem" in (others := getattr(parsed, "methods", ())) and len(others) > 1:
                options.say("--methods bem leaves out what other solvers press", prefix="note: ")
        else:
            typer.echo("[]" if as_json else "Nothing is solved by this study.")
        return
    from validation.cli.results import Bar, print_outputs

    with Bar(quiet=quiet or how.quiet or as_json) as bar:
        bench = Bench.at(store_folder, execution=execution, progress=bar)
        outputs = run_study(chosen, parsed, prepare_folder(folder), bench=bench, report=with_report)
    print_outputs(outputs, as_json=as_json)
    outputs.check()


def _scene_of_study(scene: str | None, settings: Sequence[str]) -> Scene | None:
    from validation.scenes.sweep import Sweep, load_asked

    if scene is None:
        if settings:
            raise UsageError(f"--set {settings[0]}: sets a key of a scene; name one after the study")
        return None
    loaded = load_asked(scene, settings)
    if isinstance(loaded, Sweep):
        raise UsageError(f"{scene}: [sweep] makes it many scenes; a study is asked about one")
    return loaded


def _list_studies(known: Mapping[str, Study], *, as_json: bool) -> None:
    if as_json:
        options.print_json({name: list(study.options.flags()) for name, study in known.items()})
        return
    from validation.studies import GROUPS

    listed = {name for group in GROUPS.values() for name in group}
    further = {name: study.question for name, study in known.items() if name not in listed}
    for title, group in (*GROUPS.items(), ("Of other packages", further)):
        if group:
            typer.echo(title)
        for name, words in group.items():
            star = "*" if known[name].options.takes_scene() else " "
            typer.echo(f" {star} {name:23s} {words}")
    typer.echo("\n* can be asked about a scene of yours: fem-contact study NAME SCENE")
    typer.echo("Question and options of one: fem-contact study NAME --help")
