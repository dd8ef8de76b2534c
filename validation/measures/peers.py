"""Other contact codes, where they are installed: what their contact area costs on the grids of ours."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import math
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fem_contact.area import EDGE_CONSTANTS, contact_areas
from fem_contact.solid import Solid
from fem_contact.surface import HeightField
from validation.effects.base import Slots
from validation.errors import RunFailed
from validation.measures import peer_solve
from validation.measures.common import reduced_load
from validation.measures.single_solve import SingleSolve
from validation.methods.base import Claim, Job
from validation.methods.foreign import judged
from validation.solves.solve import Prediction

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["PeerMeasurement", "code_words", "installed_peers"]

#: Part of its grid error that a peer's solver may leave in its area: equal error, not equal residual.
_SOLVER_SHARE = 0.1


def installed_peers() -> tuple[str, ...]:
    """Name the other codes that are installed, of those there is a solve for."""
    others = (name for name in peer_solve.SOLVERS if name != peer_solve.OWN)
    return tuple(name for name in others if importlib.util.find_spec(name) is not None)


def code_words(codes: Sequence[str]) -> str:
    """Say by which versions of the codes, and on which processor, their costs are measured."""
    versions = [f"{code} {_version(code)}" for code in codes]
    return f"{', '.join(versions)}, each on one thread of {_processor()}"


def _version(code: str) -> str:
    return importlib.metadata.version("fem-contact" if code == peer_solve.OWN else code)


def _processor() -> str:
    """Return the name of the processor, or its kind where the system does not say."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


@dataclass(frozen=True, kw_only=True)
class PeerMeasurement(SingleSolve):
    """One surface at one load on one grid, by another code, solved no further than its grid deserves.

    Attributes
    ----------
    code : str
        Name of its package.
    realised : Realised
        Surface, solid and load.
    grid : tuple of int
    """

    located = True

    code: str

    @property
    def recipe(self) -> dict[str, Any]:
        """Everything that determines the numbers."""
        return super().recipe | {"version": _version(self.code), "areas": "pressures"}

    @property
    def prefix(self) -> str:
        """Readable start of the name on disk."""
        return f"peer-{self.code}-{self.size}"

    def describe(self) -> str:
        """Return a few words for a progress bar."""
        return f"{self.code} {self.where}"

    def predict(self, *, pair_seconds: float = 0.5e-3) -> Prediction:
        """Predict the cost; its interpreter and the libraries it loads take most of the memory."""
        n = self.points
        return Prediction(seconds=3.0 + 5e-5 * n, peak_bytes=300 * n + 200 * 2**20, unknowns=n)

    def measure(self) -> xr.Dataset:
        """Return its areas, seconds of one thread, growth of its memory, and the tolerance it needed.

        The areas are read off its pressures by the code that reads ours, the located one among them.
        """
        import xarray as xr

        from fem_contact import bem

        own, field = self.realised, self.heights()
        ours = contact_areas(
            bem.solve(field, self.half_space, mean_pressure=own.pressure, threads=1).checked()
        )
        # Unit period, gradient and modulus: their tolerances are not free of units.
        heights = field.heights / (max(own.lengths) * own.field.rms_gradient)
        allowed = _SOLVER_SHARE * EDGE_CONSTANTS["bem"] * ours.edge_fraction
        took, pressures = self._solved(heights, pixel=ours.pixel, allowed=allowed)
        contact = judged(
            Claim(
                pressure=pressures,
                in_contact=None,
                iterations=0,
                wall_seconds=took["seconds"],
                cpu_seconds=took["seconds"],
                peak_bytes=int(took["peak_bytes"]) if math.isfinite(took["peak_bytes"]) else 0,
            ),
            Job(
                field=HeightField(heights=heights, lengths=(1.0, 1.0)),
                load={"mean_pressure": reduced_load(own)},
                slots=Slots(solid=Solid(young=1.0, poisson=0.0)),
                settings={"tolerance": took["tolerance"]},
            ),
            method=self.code,
        )
        areas = contact_areas(contact, edge_constant=EDGE_CONSTANTS["bem"], subcell=True)
        named = {name: getattr(areas, name) for name in ("pixel", "perimeter", "subcell")}
        found = {**took, **named}
        return xr.Dataset({name: ((), float(value)) for name, value in found.items()})

    def _solved(
        self, heights: np.ndarray, *, pixel: float, allowed: float
    ) -> tuple[dict[str, Any], np.ndarray]:
        """Run the code in a process of its own; return what it took, and its pressures."""
        one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "heights.npy"
            np.save(file, heights)
            numbers = (reduced_load(self.realised), pixel, allowed)
            # The file, not the module: a process that imports this package would have its memory, too.
            command = [sys.executable, "-P", peer_solve.__file__, self.code, str(file)]
            done = subprocess.run(
                [*command, *map(repr, numbers)],
                env={**os.environ, **one},
                capture_output=True,
                text=True,
                check=False,
            )
            try:
                took: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
                return took, np.load(file.with_name("pressure.npy"))
            except (ValueError, IndexError):
                last = (done.stderr.strip() or "no answer").splitlines()[-1]
                raise RunFailed(f"{self.describe()}: {last}") from None
