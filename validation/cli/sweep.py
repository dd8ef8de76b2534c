"""How a scene with a table [sweep] is run from the command line."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from validation.cli.options import naming, print_plan, stopping_cleanly
from validation.errors import UsageError

if TYPE_CHECKING:
    from validation.scenes.sweep import Sweep
    from validation.solves.running import Execution

__all__ = ["run_swept"]


def run_swept(
    sweep: Sweep,
    scene: str,
    folder: Path,
    *,
    store_folder: Path,
    execution: Execution,
    dry_run: bool,
    report: bool,
    quiet: bool,
    as_json: bool,
    unfit: Mapping[str, Any],
) -> None:
    """Run a sweep, or list its solves.

    Parameters
    ----------
    sweep : Sweep
    scene : str
        As it was asked for, for messages.
    folder, store_folder : Path
    execution : Execution
    dry_run, report, quiet, as_json : bool
    unfit : mapping
        Options of single scenes, by flag, refused if given.

    Raises
    ------
    UsageError
        For what a sweep is not run with, and for scenes that cannot be run.
    """
    from validation.cli.progress import Bar
    from validation.cli.results import print_page
    from validation.comparison.sweep import realised_cases, run_sweep, solves_of_sweep
    from validation.solves.store import Store

    given = next((flag for flag, value in unfit.items() if value), None)
    if given is not None:
        raise UsageError(
            f"{given}: not together with the table [sweep] of {scene}; run one scene of it by --set"
        )
    with naming(scene):
        cases = realised_cases(sweep)
    if dry_run:
        print_plan(solves_of_sweep(sweep, cases), Store(folder=store_folder), as_json=as_json)
        return
    with stopping_cleanly(), Bar(quiet=quiet or as_json) as bar:
        outputs = run_sweep(
            sweep,
            folder,
            cases=cases,
            progress=bar,
            execution=execution,
            store_folder=store_folder,
            report=report,
        )
    if as_json:
        typer.echo(json.dumps(outputs.page.summary, indent=2))
        outputs.check()
        return
    done = f"{outputs.solved} solves done, {outputs.reused} found finished. Written:"
    print_page(outputs.page, (*outputs.files, store_folder), done=done)
    outputs.check()
