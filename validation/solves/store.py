"""Results on disk: one file for each finished solve, written atomically, checked when read."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from validation.files import atomic_path
from validation.solves.solve import Solve

__all__ = ["Store"]

#: Errors of the machine, not of the file: no reason to throw a result away.
_NOT_DAMAGE = frozenset({errno.EACCES, errno.EPERM, errno.EMFILE, errno.ENFILE, errno.ENOMEM})


@dataclass(frozen=True, kw_only=True)
class Store:
    """The folder of finished solves; a file is there whole or not at all."""

    folder: Path

    def path(self, solve: Solve) -> Path:
        """Return where the result of a solve is, or will be."""
        return self.folder / f"{solve.key}.nc"

    def save(self, solve: Solve, result: Any) -> None:
        """Write a finished solve, and what belongs beside it.

        Raises
        ------
        RunFailed
            When the disk is full.
        """
        solve.written_beside(result, self.folder)
        with atomic_path(self.path(solve)) as draft:
            solve.write(draft, result)

    def load(self, solve: Solve, *, on_damage: Callable[[str], None] | None = None) -> Any:
        """Read a finished solve; None if there is none.

        A damaged file is set aside as `*.corrupt`, counts as none, and is told to `on_damage` in a sentence.
        """
        path = self.path(solve)
        if not path.exists():
            return None
        try:
            return solve.read(path)
        except Exception as error:
            # What a damaged HDF5 file raises depends on the byte: anything but a result is damage.
            if isinstance(error, OSError) and error.errno in _NOT_DAMAGE:
                raise
            aside = path.with_suffix(".nc.corrupt")
            with contextlib.suppress(FileNotFoundError):  # another run may have set it aside first
                os.replace(path, aside)
            if on_damage is not None:
                on_damage(f"{path}: damaged; set aside as {aside.name}, to be computed again")
            return None

    def holds(self, solve: Solve, *, on_damage: Callable[[str], None] | None = None) -> bool:
        """Whether an intact result of the solve is stored."""
        return self.load(solve, on_damage=on_damage) is not None
