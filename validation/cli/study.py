"""The command `fem-contact study`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from validation.cli import options
from validation.errors import UsageError

if TYPE_CHECKING:
    from validation.scenes.scene import Scene
    from validation.studies import Study


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
