"""Make the pictures of the gallery from the studies at their default settings.

    python docs/gallery/make.py                    # all of them: half an hour on one core
    python docs/gallery/make.py cross refinement   # those of some studies
    python docs/gallery/make.py scorecard          # our solvers beside tamaas, ContactMechanics, CalculiX
    python docs/gallery/make.py --redraw           # from the datasets in results/, solving nothing

Every study leaves all its figures (SVG, PDF, and their numbers) in results/NAME; the gallery shows a few of
them as small PNG files beside this script. Solves are kept in results/solves, beside all other studies.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from validation.execution.bench import Bench, Execution
from validation.execution.results import Outputs, show
from validation.files import prepare_folder
from validation.reference import table
from validation.report.figure import save_figure
from validation.studies import find_study
from validation.studies._outputs import run_study, study_page

#: The figures that the gallery shows, by study.
SHOWN = {
    "refinement": ("error-against-resolution", "grid-scale-by-solver"),
    "pressure": ("area-against-pressure",),
    "stress-near-zero": ("pressure-near-zero",),
    "theory-verdict": ("theory-verdict",),
    "energy": ("energy-gap-stiffness",),
    "autopsy": ("budget", "restarts"),
    "cross": ("fem-against-bem",),
    "hardness": ("plastic-area",),
    "adhesion": ("adhesive-area",),
    "adhesive-magnification": ("adhesive-by-magnification",),
    "hurst": ("kappa-against-hurst", "kappa-of-solvers"),
    "conductance": ("conductance",),
    "leak": ("leak", "gap-distribution"),
    "macroasperities": ("macroasperity-pressure", "percolation"),
    "reference": ("reference", "reference-verdict", "reference-alpha"),
    "wide-band": ("wide-band", "wide-band-laws"),
    "sliding": ("sliding",),
    "creep": ("creep",),
}

#: The solvers of the scorecard, where they are installed.
SCORED = ("bem", "fem", "tamaas", "contact_mechanics", "calculix")


#: What a page says of the files that lie beside it.
_FILES = r"Files:\s*(?:<a href=[^>]*>[^<]*</a>(?:, )?\s*)+\.\s*"


def main(arguments: Sequence[str] | None = None) -> None:
    """Run or redraw the studies that are asked for, and save their pictures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    known = [*SHOWN, "scorecard"]
    parser.add_argument("studies", nargs="*", metavar="STUDY", help=f"Of {', '.join(known)}; default: all.")
    parser.add_argument("--redraw", action="store_true", help="From results/NAME, without solving.")
    parser.add_argument("--workers", type=int, default=1, help="Local processes that solve.")
    parser.add_argument("--output", type=Path, default=Path(__file__).parent, help="Default: beside this.")
    said = parser.parse_args(arguments)
    if unknown := set(said.studies) - set(known):
        parser.error(f"{', '.join(sorted(unknown))}: not in the gallery; one of: {', '.join(known)}")
    for name in said.studies or (SHOWN if said.redraw else known):
        if name == "scorecard":
            _scorecard(said.output)
            continue
        if name == "reference":  # of the table that is shipped: to make it takes hours
            drawings = find_study(name).figures(table())
        else:
            drawings = _outputs(name, redraw=said.redraw, workers=said.workers).page.figures
        figures = {drawing.name: drawing.figure for drawing in drawings}
        for shown in SHOWN[name]:
            target = said.output / f"{shown}.png"
            save_figure(figures[shown], target, dpi=100)
            # 64 colours draw lines and letters as well as millions do, in a third of the bytes.
            Image.open(target).convert("RGB").quantize(64).save(target, optimize=True)
            print(f"{target}: {target.stat().st_size / 1024:.0f} KB")


def _scorecard(folder: Path) -> None:
    """Score our solvers beside those of others that are installed, and write their page."""
    from validation.cases._result import write_scorecards
    from validation.cases.scorecard import Subject, score
    from validation.solvers import find_solver

    solvers = {name: find_solver(name) for name in SCORED}
    subjects = [
        Subject(name=name, solver=solver, settings={}, quick=False)
        for name, solver in solvers.items()
        if solver.available() is None
    ]
    cards = [score(subject, tell=print) for subject in subjects]
    results = prepare_folder(Path("results") / "scorecard")
    page = prepare_folder(folder) / "scorecard.html"
    told = write_scorecards(results, cards).files[0].read_text(encoding="utf-8")
    # It stands alone here: the files of its figures are in results/scorecard.
    page.write_text(re.sub(_FILES, "", told), encoding="utf-8")
    print(f"{page}: {page.stat().st_size / 1024:.0f} KB")


def _outputs(name: str, *, redraw: bool, workers: int) -> Outputs:
    folder = prepare_folder(Path("results") / name)
    if redraw:
        return show(folder, study_page)
    study, bench = find_study(name), Bench.at(execution=Execution(workers=workers))
    return run_study(study, study.options(), folder, bench=bench)


if __name__ == "__main__":
    main()
