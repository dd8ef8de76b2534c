"""Gold numbers of scenes: runs, sweeps, the theory alone, runs to an accuracy, and results side by side."""

from reading_back import misdrawn

from gold.asked import ACCURATE, COMPARED, SCENES
from gold.make import of_dataset, of_page
from validation.audit import audit
from validation.comparison.accuracy import run_accurate
from validation.comparison.compare import compare_folders
from validation.comparison.run import result_page, run_scene, run_sweep
from validation.execution.bench import Bench
from validation.execution.results import read_results
from validation.scenes.sweep import Sweep, load_asked


def of_scene(name, bench, folder):
    """Run what an entry asks for as the command line does, and read what it left."""
    solves = bench.store.folder
    if name in COMPARED:
        folders = [folder / f"run-{k}" for k in range(len(COMPARED[name]))]
        for one, results in zip(COMPARED[name], folders, strict=True):
            _ran(one, solves, results)
        page = compare_folders(folders, folder / "both").page
        data = read_results(folder / "both").data
    else:
        data = _ran(name, solves, folder / "run")
        page = result_page(read_results(folder / "run"), figures=True)
    odd = [] if "solve" not in data or name in COMPARED else list(map(str, audit(folder / "run").wrong))
    odd += [problem for drawing in page.figures for problem in misdrawn(drawing, data)]
    return {**of_dataset(name, data), **of_page(name, page, odd)}, data


def _ran(name, solves, results):
    scene, settings = SCENES[name]
    if "\n" in scene:
        path = results.parent / "mine.toml"
        path.write_text(scene, encoding="utf-8")
        scene = str(path)
    asked = load_asked(scene, settings, grids_chosen=name in ACCURATE)
    if isinstance(asked, Sweep):
        run_sweep(asked, results, bench=Bench.at(solves), report=False)
    elif name in ACCURATE:
        run_accurate(asked, results, target=ACCURATE[name], bench=Bench.at(solves), report=False)
    else:
        run_scene(asked, results, bench=Bench.at(solves), report=False)
    return read_results(results).data
