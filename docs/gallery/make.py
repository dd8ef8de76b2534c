"""Make the pictures of the gallery from the studies at their default settings.

    python docs/gallery/make.py                    # all of them: a quarter of an hour on one core
    python docs/gallery/make.py cross refinement   # those of some studies
    python docs/gallery/make.py --redraw           # from the datasets in results/, solving nothing

Every study leaves all its figures (SVG, PDF, and their numbers) in results/NAME; the gallery shows a few of
them as small PNG files beside this script. Solves are kept in results/solves, beside all other studies.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from PIL import Image

from validation.files import prepare_folder
from validation.report.figure import save_figure
from validation.solves.bench import Bench
from validation.solves.running import Execution
from validation.studies import find_study
from validation.studies._outputs import StudyOutputs, report_study, run_study

#: The figures that the gallery shows, by study.
SHOWN = {
    "refinement": ("error-against-resolution",),
    "pressure": ("area-against-pressure",),
    "stress-near-zero": ("pressure-near-zero",),
    "theory-verdict": ("theory-verdict",),
    "autopsy": ("budget", "restarts"),
    "cross": ("fem-against-bem",),
    "hardness": ("plastic-area",),
    "adhesion": ("adhesive-area",),
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run or redraw the studies that are asked for, and save their pictures."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("studies", nargs="*", metavar="STUDY", help=f"Of {', '.join(SHOWN)}; default: all.")
    parser.add_argument("--redraw", action="store_true", help="From results/NAME, without solving.")
    parser.add_argument("--workers", type=int, default=1, help="Local processes that solve.")
    parser.add_argument("--output", type=Path, default=Path(__file__).parent, help="Default: beside this.")
    said = parser.parse_args(arguments)
    if unknown := set(said.studies) - set(SHOWN):
        parser.error(f"{', '.join(sorted(unknown))}: not in the gallery; one of: {', '.join(SHOWN)}")
    for name in said.studies or SHOWN:
        outputs = _outputs(name, redraw=said.redraw, workers=said.workers)
        figures = {drawing.name: drawing.figure for drawing in outputs.page.figures}
        for shown in SHOWN[name]:
            target = said.output / f"{shown}.png"
            save_figure(figures[shown], target, dpi=100)
            # 64 colours draw lines and letters as well as millions do, in a third of the bytes.
            Image.open(target).convert("RGB").quantize(64).save(target, optimize=True)
            print(f"{target}: {target.stat().st_size / 1024:.0f} KB")


def _outputs(name: str, *, redraw: bool, workers: int) -> StudyOutputs:
    folder = prepare_folder(Path("results") / name)
    if redraw:
        return report_study(folder)
    study, bench = find_study(name), Bench.at(execution=Execution(workers=workers))
    return run_study(study, study.options(), folder, bench=bench)


if __name__ == "__main__":
    main()
