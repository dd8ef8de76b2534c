"""The block at finite strain by CalculiX: the same places of the surface nodes take the same forces."""

import os
import shutil
import subprocess

import numpy as np
import pytest

from fem_contact import Solid
from fem_contact.block import solve_finite_strain
from tests.surfaces import rough_surface

SOLID = Solid(young=1e6, poisson=0.3)


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_calculix_finds_our_contact_forces_where_our_nodes_are(tmp_path):
    surface = rough_surface((8, 8), seed=11, waves=2, gradient=0.5)
    pressure = 0.1 * 0.5 * SOLID.contact_modulus
    found = solve_finite_strain(surface, SOLID, mean_pressure=pressure, depth=0.5, growth=2.0)
    (tmp_path / "block.inp").write_text("\n".join(_deck(found)) + "\n", encoding="ascii")
    alone = {**os.environ, "OMP_NUM_THREADS": "1"}
    subprocess.run(["ccx", "block"], cwd=tmp_path, check=True, capture_output=True, timeout=60, env=alone)
    force = SOLID.young * found.state.force[..., None]
    slope = found.press.below(found.state.field).slope
    # Normal to the profile and downwards on the nodes in contact, none elsewhere; files have seven digits.
    ours = np.concatenate([-force * slope, -force], axis=-1)
    reactions = _reactions((tmp_path / "block.dat").read_text(encoding="ascii"), found)
    assert np.abs(reactions - ours).max() < 1e-6 * np.abs(ours).max()


def _deck(found):
    """The block held at the places of its surface nodes, at large deflection, of the same neo-Hookean law."""
    mesh, (nx, ny) = found.mesh, found.mesh.cells
    shear, bulk = SOLID.shear_modulus, SOLID.young / (3 * (1 - 2 * SOLID.poisson))
    corners = [(i, j) for i in range(nx + 1) for j in range(ny + 1)]

    def node(i, j, k):
        return 1 + i * (ny + 1) + j + len(corners) * k

    yield "*NODE,NSET=ALL"
    for k, z in enumerate(mesh.edges):
        yield from (f"{node(i, j, k)},{i}.,{j * mesh.aspect:.13g},{z:.13g}" for i, j in corners)
    yield "*ELEMENT,TYPE=C3D8,ELSET=BLOCK"
    around = [(a, b, c) for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
    for number, (i, j, k) in enumerate(np.ndindex(nx, ny, mesh.nz)):
        yield f"{number + 1}," + ",".join(str(node(i + a, j + b, k + c)) for a, b, c in around)
    yield from ("*MATERIAL,NAME=SOLID", "*HYPERELASTIC,NEO HOOKE", f"{shear / 2:.13g},{2 / bulk:.13g}")
    yield from ("*SOLID SECTION,ELSET=BLOCK,MATERIAL=SOLID", "*EQUATION")
    for k in range(1, mesh.nz):
        for i, j in corners:
            if i == nx or j == ny:
                for axis in (1, 2, 3):
                    yield f"2\n{node(i, j, k)},{axis},1.,{node(i % nx, j % ny, k)},{axis},-1."
    yield from ("*NSET,NSET=BASE", *(str(node(i, j, 0)) for i, j in corners))
    yield from ("*NSET,NSET=TOP", *(str(node(i, j, mesh.nz)) for i, j in corners))
    yield from ("*STEP,NLGEOM,INC=1000", "*STATIC,SOLVER=SPOOLES", "0.25,1.")
    yield from ("*CONTROLS,PARAMETERS=FIELD", "1e-7,1e-7", "*BOUNDARY", "BASE,1,3")
    for i, j in corners:
        for axis, part in enumerate(found.state.field[i % nx, j % ny, -1], start=1):
            yield f"{node(i, j, mesh.nz)},{axis},{axis},{part:.12e}"
    yield from ("*NODE PRINT,NSET=TOP", "RF", "*END STEP")


def _reactions(printed, found):
    """Forces on the surface nodes in the last table, those of periodic images together."""
    nx, ny = found.mesh.cells
    rows = [line.split() for line in printed.splitlines()]
    last = [row for row in rows if len(row) == 4 and row[0].isdigit()][-(nx + 1) * (ny + 1) :]
    forces = np.array([[float(part) for part in row[1:]] for row in last]).reshape(nx + 1, ny + 1, 3)
    forces[0] += forces[-1]
    forces[:, 0] += forces[:, -1]
    return forces[:-1, :-1]
