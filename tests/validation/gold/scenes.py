"""Gold numbers of scenes: runs, sweeps, the theory alone, runs to an accuracy, and results side by side."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import xarray as xr

from gold.asked import ACCURATE, COMPARED, SCENES
from gold.make import Record, of_page
from validation.comparison.accuracy import run_accurate
from validation.comparison.beside import beside
from validation.comparison.beside_page import beside_page
from validation.comparison.report import run_page
from validation.comparison.run import Outputs, run_scene
from validation.comparison.sweep import run_sweep
from validation.comparison.sweep_page import sweep_page
from validation.comparison.theory_alone import TheoryAlone, alone_page
from validation.report.page import Page
from validation.scenes.sweep import Sweep, load_asked
from validation.solves.press import solves_of
from validation.solves.running import Solves
from validation.solves.store import Store

__all__ = ["of_scene"]


def of_scene(name: str, folder: Path) -> tuple[Record, xr.Dataset]:
    """Run what an entry asks for as the command line does; its page has its figures, but draws none."""
    page = _compared(name, folder) if name in COMPARED else _ran(name, folder, folder / "run")
    return of_page(name, page), page.data if page.data is not None else xr.Dataset()


def _ran(name: str, folder: Path, results: Path) -> Page:
    scene, settings = SCENES[name]
    if "\n" in scene:
        path = folder / "mine.toml"
        path.write_text(scene, encoding="utf-8")
        scene = str(path)
    asked = load_asked(scene, settings, grids_chosen=name in ACCURATE)
    told = {"store_folder": folder / "solves", "report": False}
    if isinstance(asked, Sweep):
        data = run_sweep(asked, results, **told).data
        return sweep_page(data, asked.keys, asked.scenes[0])
    if name in ACCURATE:
        return _page(run_accurate(asked, results, target=ACCURATE[name], **told).outputs, folder)
    return _page(run_scene(asked, results, **told), folder)


def _page(outputs: Outputs, folder: Path) -> Page:
    found = outputs.comparison
    if isinstance(found, TheoryAlone):
        return alone_page(found)
    solves = solves_of(found.scene, found.realised)
    return run_page(found, Solves(solves=solves, store=Store(folder=folder / "solves")))


def _compared(name: str, folder: Path) -> Page:
    folders = [folder / f"run-{k}" for k in range(len(COMPARED[name]))]
    for one, results in zip(COMPARED[name], folders, strict=True):
        _ran(one, folder, results)
    found = beside(folders)
    steady = tuple(row for row in found.rows if row.quantity != "seconds")
    return beside_page(replace(found, rows=steady))
