"""The command `fem-contact compare`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from validation.cli.options import JsonOption, OutputOption, ReportOption


def compare(
    folders: Annotated[
        list[Path], typer.Argument(metavar="DIR DIR...", help="Results folders of one kind; the first leads.")
    ],
    output: OutputOption = None,
    with_report: ReportOption = True,
    as_json: JsonOption = False,
) -> None:
    """Put finished runs or studies side by side: what differs, and by how much.

    Differences are told in uncertainties. The first folder is what the others are compared with. Runs
    are compared with runs, sweeps with sweeps, and a study with the same study of other options.
    """
    from validation.cli.progress import under_way
    from validation.cli.results import print_outputs
    from validation.comparison.compare import compare_folders

    names = "-".join(re.sub(r"[^A-Za-z0-9._-]", "-", folder.resolve().name) for folder in folders)
    target = output or Path("results") / f"compare-{names[:80]}"
    with under_way("comparing, drawing figures", quiet=as_json):
        outputs = compare_folders(folders, target, report=with_report)
    print_outputs(outputs, as_json=as_json)
