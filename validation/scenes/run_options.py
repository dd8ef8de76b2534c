"""The table [run] of a scene: how it is run, which changes no result."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, StrictBool, StrictInt, model_validator

from validation.errors import UsageError
from validation.units import Memory, Table, key, wrong


def _inside(path: Path) -> Path:
    """Refuse a folder outside the one a scene runs in: a scene may not choose what is written over."""
    if path.is_absolute() or path.drive or ".." in path.parts:
        raise wrong(
            "must lie below the folder the scene runs in, such as 'results/mine'; any other is named on the "
            "command line"
        )
    return path


Inside = Annotated[Path, AfterValidator(_inside)]


class RunOptions(Table):
    """How a scene is run; nothing here changes a result. An option of the command line goes before these.

    Where it runs beyond this machine and this folder is no matter of a scene, which may come from elsewhere:
    a scheduler, and folders outside, are named on the command line alone.
    """

    workers: Annotated[StrictInt, Field(ge=1, le=4096)] = key(
        "local processes, e.g. 4; 1 runs everything in the process itself", 1
    )
    memory: Memory | None = key('memory for all solves, e.g. "4 GiB"', None)
    store: Inside | None = key('folder of finished solves, shared between runs, e.g. "results/solves"', None)
    output: Inside | None = key('results folder, e.g. "results/mine"; default: results/<name>', None)
    quiet: StrictBool = key("no progress bar", False)
    pictures: StrictBool = key("3-D pictures in the report", False)

    @model_validator(mode="before")
    @classmethod
    def _no_scheduler(cls, data: object) -> object:
        if isinstance(data, dict) and "scheduler" in data:
            raise wrong("scheduler: is chosen on the command line alone: --scheduler tcp://host:8786")
        return data

    def folder(self, key: Literal["output", "store"]) -> Path | None:
        """Return a folder that the scene names, None if it does not; links may not lead outside, either."""
        path: Path | None = getattr(self, key)
        return None if path is None else not_led_out(path, of=Path(), option=f"--{key}")


def not_led_out(path: Path, *, of: Path, option: str) -> Path:
    """Refuse a folder that a link leads out of another; what came with a scene may hold such links."""
    led = Path(os.path.realpath(path))  # of a link to itself, itself
    if not led.is_relative_to(os.path.realpath(of)):
        raise UsageError(
            f"{str(path)!r} is a link that leads to {str(led)!r}; remove it, or say {option} {str(path)!r} "
            "to follow it"
        )
    return path
