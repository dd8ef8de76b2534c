"""The elastic block by CalculiX: linear hexahedra and gap elements, from a deck written here.

The mesh is that of our own block, so that the two can be compared node by node: nodal forces over the area
of a node are the pressures. A number of a deck has at most twenty characters.
"""

from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fem_contact import contact
from fem_contact.errors import NotConverged
from validation.arrays import Array
from validation.effects.base import Effect
from validation.solvers.base import Blocks, Claim, Cost, Job, Size, Solved
from validation.solvers.external import verified
from validation.solvers.fem import BlockSolver, planned, unknowns_of
from validation.units import Duration, key

if TYPE_CHECKING:
    from validation.scenes.problem import ContactProblem

#: Young's modulus in the deck: its criteria are absolute, and forces must be large beside them.
_YOUNG = 1e12
#: Poisson ratio up to which its cells answer as those of `fem`: at .45 the area is 8 % smaller, at .49 18 %.
_LOCKING = 0.4
#: Range of the heights over the longer period in the deck, or its mean strain: gap elements make it a problem
#: of finite deflections, which are too small to matter, and the answer is scaled back.
_RANGE = 3e-8
#: Stiffness of a closed gap over E dx: pressures are off by about .6 over it.
_STIFF = 1e6
#: Force across an open gap over the mean force of a node.
_OPEN = 1e-10
_SECONDS, _ACCEPTED = 600.0, 1e-5
#: Direct factorisation: pairs of transforms and bytes per unknown to the power of 5/3 and 4/3.
_PAIRS, _BYTES = 3e-4, 40.0


class CalculixOptions(Blocks):
    """The block by CalculiX on these surface grids; direct linear solves, so that 32 x 32 is large."""

    tolerance: float = key(
        "largest residual that is accepted; its files carry seven digits", _ACCEPTED, gt=0, lt=1e-1
    )
    seconds: Duration | None = key("time one solve may take; default: 10 min", None)


class Calculix(BlockSolver):
    """Linear hexahedra (C3D8) and gap elements (GAPUNI) of CalculiX."""

    name = "calculix"
    label = "CalculiX"
    options = CalculixOptions
    foreign = True
    slots = frozenset({"response"})
    score_points = 8
    setting_keys = ("tolerance", "growth", "depth", "seconds")
    papers = ("CalculiX: [dhondt2004].",)

    def available(self) -> str | None:
        """Say what to install."""
        if shutil.which("ccx") is not None:
            return None
        return "CalculiX is not installed; put its program ccx on the path, by: apt install calculix-ccx"

    def handles(self, effect: type[Effect]) -> bool:
        """Whether it is the layer: a block of that depth."""
        return effect.kind_name() == "thickness"

    def check(self, options: CalculixOptions, problem: ContactProblem, effects: Sequence[Effect]) -> None:
        """Refuse a layer that is not bonded to its base, two depths, and a solid on which its cells lock."""
        self.check_locking(problem, above=_LOCKING)
        self.check_bodies(problem, effects, depth=options.depth)

    def cost(self, size: Size) -> Cost:
        """Predict from the unknowns of the mesh."""
        unknowns = unknowns_of(size, "full")
        return size.cost(_PAIRS * unknowns ** (5 / 3), _BYTES * unknowns ** (4 / 3), unknowns)

    def solve(self, job: Job) -> Solved:
        """Write the deck, run ccx, and judge the nodal forces it prints.

        A NotConverged when it fails, takes too long, or prints no answer.
        """
        clock, began = os.times(), time.perf_counter()
        field, young = job.field, job.model.solid.young
        longest = max(field.lengths)
        shrink = _RANGE / max(float(np.ptp(field.heights)) / longest, job.mean_pressure / young)
        # Pa and m for one unit of pressure and displacement of the deck.
        stress, length = young / (_YOUNG * shrink), longest / shrink
        planes = planned(job).edges[::-1] * field.spacing[0] / longest
        sides = (field.lengths[0] / longest, field.lengths[1] / longest)
        load = job.mean_pressure / stress
        deck = _deck(
            field.heights * (shrink / longest), sides, planes, poisson=job.model.solid.poisson, load=load
        )
        forces, rises = _run(deck, field.shape, seconds=float(job.settings.get("seconds", _SECONDS)))
        claim = Claim(
            pressure=-forces / (sides[0] * sides[1] / field.heights.size) * stress,
            cost=contact.Cost(
                wall_seconds=time.perf_counter() - began,
                cpu_seconds=os.times().children_user - clock.children_user,
                iterations=0,
                unknowns=3 * field.heights.size * (planes.size - 1),
                peak_bytes=0,
            ),
        )
        accepted_job = replace(job, settings={"tolerance": _ACCEPTED, **job.settings})
        rise = -rises * length
        judged = verified(claim, accepted_job, method=self.label, element="Hex1", displacement=rise)
        return Solved(contact=judged)


def _run(deck: Iterable[str], shape: tuple[int, int], *, seconds: float) -> tuple[Array, Array]:
    """Run ccx in a folder of its own; return forces on the rigid nodes, and rises of the surface."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "block.inp").write_text("\n".join(deck) + "\n", encoding="ascii")
        try:
            done = subprocess.run(
                ["ccx", "block"],
                cwd=folder,
                capture_output=True,
                text=True,
                timeout=seconds,
                check=False,
                env={**os.environ, "OMP_NUM_THREADS": "1"},
            )
        except subprocess.TimeoutExpired:
            raise NotConverged(f"ccx: took more than {seconds:.3g} s: allow more `seconds`") from None
        printed = Path(folder, "block.dat")
        text = printed.read_text(encoding="ascii") if printed.exists() else ""
    # The vertical components of each table of node, x, y, z; a heading is no number.
    tables = (
        re.findall(r"(?m)^ *\d+ +\S+ +\S+ +(\S+) *$", part) for part in re.split(r"(?m)^ *[^\d\s].*$", text)
    )
    blocks = [block for block in tables if len(block) == math.prod(shape)]
    if done.returncode != 0 or len(blocks) < 2:
        errors = [line.strip() for line in done.stdout.splitlines() if "ERROR" in line]
        raise NotConverged(f"ccx: {errors[0] if errors else 'ended without an answer'}")
    forces, rises = (np.array(block, dtype=float).reshape(shape) for block in blocks[-2:])
    return forces, rises


def _deck(
    heights: Array, sides: tuple[float, float], planes: Array, *, poisson: float, load: float
) -> Iterator[str]:
    """Yield the lines of the deck: longer period 1, heights of `_RANGE`, modulus `_YOUNG`.

    `planes` are the z of the planes of nodes, from 0 downwards. The highest point of the profile touches.
    """
    nx, ny = (int(n) for n in heights.shape)
    layers, dx, dy = int(planes.size) - 1, sides[0] / nx, sides[1] / ny
    node = 1 + np.arange(planes.size * (nx + 1) * (ny + 1)).reshape(-1, nx + 1, ny + 1)  # by k, i, j
    rigid = 1 + node.size + np.arange(nx * ny).reshape(nx, ny)
    columns, corners = list(np.ndindex(nx, ny)), list(np.ndindex(nx + 1, ny + 1))
    yield "*NODE,NSET=ALL"
    for k, z in enumerate(planes):
        for i, j in corners:
            yield f"{node[k, i, j]},{i * dx:.13g},{j * dy:.13g},{z:.13g}"
    for i, j in columns:
        yield f"{rigid[i, j]},{i * dx:.13g},{j * dy:.13g},{dx:.13g}"
    yield "*ELEMENT,TYPE=C3D8,ELSET=BLOCK"
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    for k in range(layers):
        for i, j in columns:
            nodes = [node[below, i + a, j + b] for below in (k + 1, k) for a, b in around]
            yield f"{1 + k * nx * ny + i * ny + j},{','.join(map(str, nodes))}"
    stiffness, force = _STIFF * _YOUNG * dx, _OPEN * load * dx * dy
    for k, (i, j) in enumerate(columns):
        yield f"*ELEMENT,TYPE=GAPUNI,ELSET=G{k}"
        yield f"{1 + layers * nx * ny + k},{node[0, i, j]},{rigid[i, j]}"
        yield f"*GAP,ELSET=G{k}"
        yield f"{heights.max() - heights[i, j]:.12e},0.,0.,1.,,{stiffness:.8e},{force:.8e}"
    yield from ("*MATERIAL,NAME=SOLID", "*ELASTIC", f"{_YOUNG:.13g},{poisson:.13g}")
    yield "*SOLID SECTION,ELSET=BLOCK,MATERIAL=SOLID"
    yield "*EQUATION"
    for k in range(layers):  # the base is held already
        for i, j in corners:
            if i == nx or j == ny:
                for axis in (1, 2, 3):
                    yield "2"
                    yield f"{node[k, i, j]},{axis},1.,{node[k, i % nx, j % ny]},{axis},-1."
    for other in rigid.flat[1:]:
        yield "2"
        yield f"{other},3,1.,{rigid[0, 0]},3,-1."
    for name, members in {"BASE": node[-1], "TOP": node[0, :-1, :-1], "RIGID": rigid}.items():
        yield f"*NSET,NSET={name}"
        yield from map(str, members.flat)
    yield from ("*BOUNDARY", "BASE,1,3", "RIGID,1,2")
    yield from ("*STEP,NLGEOM,INC=1000", "*STATIC,SOLVER=SPOOLES", "1.,1.")
    yield from ("*CLOAD", f"{rigid[0, 0]},3,{-load * sides[0] * sides[1]:.12e}")
    yield from ("*NODE PRINT,NSET=RIGID", "RF", "*NODE PRINT,NSET=TOP", "U", "*END STEP")
