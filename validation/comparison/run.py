"""Running a scene: check everything first, solve what is not stored yet, compare, write the results."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from validation.errors import UsageError
from validation.files import json_text, prepare_folder, write_json
from validation.methods.handled import check_effects
from validation.report.page import clear_page
from validation.scenes.surfaces import reference_field
from validation.solves.running import Execution, Progress, solve_jobs
from validation.solves.solve import jobs_of
from validation.solves.store import Store

if TYPE_CHECKING:
    from validation.comparison.compare import Comparison
    from validation.report.page import Page
    from validation.scenes.scene import Scene

__all__ = ["ACCURACY_FILE", "Outputs", "load_run", "report_run", "run_scene"]

_RUN_FILE = "run.json"
_RUN_FORMAT = "fem-contact run 1"

#: What a run to an accuracy reached, in its results folder.
ACCURACY_FILE = "accuracy.json"


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """What a run left behind.

    Attributes
    ----------
    comparison : Comparison
    page : Page
    folder : Path
    files : tuple of Path
        Everything a reader may want to open, the report first.
    solved, reused : int
        Jobs solved now, and jobs found finished.
    """

    comparison: Comparison
    page: Page
    folder: Path
    files: tuple[Path, ...]
    solved: int
    reused: int


def run_scene(
    scene: Scene,
    folder: Path,
    *,
    progress: Progress | None = None,
    execution: Execution | None = None,
    store_folder: Path | None = None,
    pictures: bool = False,
    report: bool = True,
    accurate: bool = False,
) -> Outputs:
    """Run a scene into a folder; finished solves found in the store are used, not repeated.

    Parameters
    ----------
    scene : Scene
    folder : Path
        For tables, figures and report.
    progress : Progress, optional
    execution : Execution, optional
        Where the solves run; in this process if not given.
    store_folder : Path, optional
        Where the solves are kept, to be shared with other runs and studies; `folder`/solves if not given.
    pictures : bool
        Whether the report gets 3-D pictures, rendered off screen in some seconds.
    report : bool
        Whether to draw figures and write the report, which `report_run` can do later.
    accurate : bool
        Whether the grids were chosen for an accuracy; a plain run removes what an earlier such run reached.

    Raises
    ------
    UsageError
        For a scene or folder that cannot be used, before anything is computed.
    RunFailed
        When a solve fails; everything finished is stored.
    """
    check_effects(scene)
    reference_field(scene.surface)
    prepare_folder(folder)
    store = Store(folder=prepare_folder(store_folder or folder / "solves", option="--store"))
    if not accurate:
        # What an earlier run to an accuracy reached is not what this one finds.
        (folder / ACCURACY_FILE).unlink(missing_ok=True)
    _record(scene, folder, store)
    jobs = jobs_of(scene)
    solved = solve_jobs(jobs, store, progress=progress, execution=execution)
    return _compared(scene, store, folder, pictures=pictures, report=report, accurate=accurate, solved=solved)


def report_run(folder: Path, *, pictures: bool | None = None) -> Outputs:
    """Write tables, figures and report of a finished run again, from its stored solves alone.

    Parameters
    ----------
    folder : Path
    pictures : bool, optional
        Whether to render 3-D pictures, too; if not given, where the scene asks or the folder has some.

    Raises
    ------
    UsageError
        For a folder that holds no run.
    RunFailed
        When a solve of the run is missing.
    """
    scene, store = load_run(folder)
    accurate = (folder / ACCURACY_FILE).exists()
    if pictures is None:
        pictures = scene.run.pictures or any(folder.glob("figures/*.png"))
    return _compared(scene, store, prepare_folder(folder), pictures=pictures, accurate=accurate, solved=0)


def _compared(
    scene: Scene,
    store: Store,
    folder: Path,
    *,
    pictures: bool,
    accurate: bool,
    solved: int,
    report: bool = True,
) -> Outputs:
    from validation.comparison.compare import compare
    from validation.comparison.report import write_outputs

    comparison = compare(scene, store, accurate=accurate)
    page, files = write_outputs(comparison, store, folder, pictures=pictures, report=report)
    return Outputs(
        comparison=comparison,
        page=page,
        folder=folder,
        files=files,
        solved=solved,
        reused=len(jobs_of(scene)) - solved,
    )


def _record(scene: Scene, folder: Path, store: Store) -> None:
    """Write down what the folder is a run of, so that its report can be made again without the scene file.

    A report of something else goes first: if this run is interrupted, nothing in the folder belies it.
    """
    said = {
        "format": _RUN_FORMAT,
        "scene": scene.model_dump(mode="json", exclude_none=True),
        "store": os.path.relpath(store.folder.resolve(), folder.resolve()),
    }
    path = folder / _RUN_FILE
    if not (path.exists() and path.read_bytes() == json_text(said).encode()):
        clear_page(folder)
    (folder / "study.json").unlink(missing_ok=True)
    write_json(path, said)


def load_run(folder: Path) -> tuple[Scene, Store]:
    """Return the scene and the store of the run in a folder.

    Raises
    ------
    UsageError
        When the folder holds none.
    """
    from validation.scenes.scene import Scene

    path = folder / _RUN_FILE
    try:
        said = json.loads(path.read_text(encoding="utf-8"))
        if said["format"] != _RUN_FORMAT:
            raise ValueError
        scene = Scene.model_validate(said["scene"])
        return scene, Store(folder=(folder / said["store"]).resolve())
    except OSError as error:
        raise UsageError(
            f"{folder}: holds no run ({_RUN_FILE}: {error.strerror}); name a results folder"
        ) from None
    except (ValueError, KeyError, TypeError):
        raise UsageError(f"{path}: is not the record of a run of this version; run the scene again") from None
