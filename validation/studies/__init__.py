"""Studies: one file, or one folder, for each question; found by name or entry point.

ARCHITECTURE.md says how one is written.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from validation.errors import UsageError, did_you_mean
from validation.registry import entries
from validation.scenes.mistakes import problems
from validation.studies._options import StudyOptions
from validation.studies._study import Study

if TYPE_CHECKING:
    import xarray as xr

    from validation.execution.bench import Bench

__all__ = ["GROUPS", "Study", "StudyOptions", "find_study", "run", "studies"]

#: The studies that come with the package, in groups: what each gives in one line.
GROUPS: Mapping[str, Mapping[str, str]] = {
    "How large is the contact?": {
        "area": "contact area against the load, every field kept",
        "pressure": "area, gap, stiffness, energy, patches over the load",
        "hurst": "kappa = (A/A0)/p* against the Hurst exponent",
        "magnification": "contact area as shorter and shorter waves are added",
        "archard": "bumps on bumps: does area grow as the load does?",
        "macroasperities": "patches of contact, and where contact percolates",
        "reference": "the table that fem-contact reference looks up",
    },
    "How good is Persson's theory?": {
        "theory-verdict": "the theory and its variants, quantity by quantity",
        "reference-score": "a theory, or your areas, on all cells of the table",
        "wide-band": "does its area become exact as the band widens?",
        "autopsy": "which terms of its diffusion equation fail, and where",
        "stress-near-zero": "does P(sigma) vanish at sigma = 0, with which slope?",
        "energy": "energy, gap and stiffness beside every theory",
        "heights": "are heights Gaussian, and does it decide the contact?",
        "graded": "the modulus that a wave feels, against the exact one",
    },
    "What else acts in a contact?": {
        "adhesion": "how much attraction enlarges the contact",
        "adhesive-magnification": "adhesive contact as shorter waves are added",
        "hardness": "how much of the contact has yielded",
        "conductance": "conductance and stiffness, from light to full contact",
        "leak": "does the gap percolate, how much leaks through it?",
        "sliding": "friction and contact area on rubber over the velocity",
        "creep": "contact at rest on rubber: its growth, and its memory",
        "large-slope": "up to which slope does linear theory hold?",
    },
    "How far can the numbers be trusted?": {
        "refinement": "what a grid overestimates, and what is left of it",
        "cross": "do solvers agree, the better the finer the grid?",
        "depth": "how deep a block must be, and which elements it takes",
        "stability": "how far each method can be pushed before it breaks",
        "accuracy-cost": "what each digit of the contact area costs",
        "scaling": "time and memory of one more decade of lengths",
    },
}


@cache
def studies() -> Mapping[str, Study]:
    """Return all studies by name; a name is that of its module with hyphens.

    A UsageError for an entry point that cannot be loaded, is no study, or has a name that is taken.
    """
    names = sorted(info.name for info in pkgutil.iter_modules(__path__) if not info.name.startswith("_"))
    modules = {name.replace("_", "-"): importlib.import_module(f"{__name__}.{name}") for name in names}
    for where, name, module in entries("fem_contact.studies"):
        if name in modules:
            raise UsageError(
                f"{where}: the name {name!r} is that of {modules[name].__name__}; have it renamed"
            )
        lacking = [part for part in ("Options", "run", "views") if not hasattr(module, part)]
        if lacking:
            raise UsageError(f"{where}: must be a module with {', '.join(map(repr, lacking))}")
        modules[name] = module
    return {name: Study(name=name, module=module) for name, module in modules.items()}


def find_study(name: str) -> Study:
    """Return one study.

    A UsageError for an unknown name.
    """
    known = studies()
    if not isinstance(name, str) or name not in known:
        if str(name).startswith("-"):
            raise UsageError(f"study {name}: no such option{did_you_mean(name, ['--list', '--help'])}")
        raise UsageError(
            f"study {name!r}: no such study{did_you_mean(str(name), known)}; one of: {', '.join(known)}"
        )
    return known[name]


def run(name: str, *, bench: Bench | str | Path | None = None, **options: Any) -> xr.Dataset:
    """Run a study from Python and return its dataset; ``study.hurst(...)`` is ``study("hurst", ...)``.

    ``study.figures(data)``, ``study.table(data)``, ``study.budget(data)`` and ``study.findings(data)`` are what
    its report shows of a dataset.

    A UsageError for an unknown study or option, and a line for each value that is not allowed.

    Parameters
    ----------
    bench : folder or Bench, optional
        Where the solves are kept, and run; in this process and in results/solves if not given.
    options
        Those of ``fem-contact study NAME --help``, with underscores for hyphens.

    Examples
    --------
    >>> run("hurst", hurst=0.5)
    Traceback (most recent call last):
    validation.errors.UsageError: study hurst: unknown key 'hurst'; did you mean 'hursts'?...
    """
    from validation.execution.bench import DEFAULT_STORE, Bench

    if bench is None or isinstance(bench, (str, Path)):
        bench = Bench.at(bench or DEFAULT_STORE)
    if not isinstance(bench, Bench):
        raise UsageError(f'study: bench = {bench!r}: give a folder, such as "results/solves"')
    study = find_study(name)
    try:
        parsed = study.options(**options)
    except ValidationError as error:
        raise UsageError(f"study {name}: " + "\n".join(problems(error))) from None
    return study.compute(parsed, bench=bench)


# Attributes of the function, so that a notebook completes their names: study.hurst(...) is run("hurst", ...).
for _name in (name for group in GROUPS.values() for name in group):
    setattr(run, _name.replace("-", "_"), partial(run, _name))


def _of_dataset(part: str, data: xr.Dataset) -> Any:
    return getattr(find_study(str(getattr(data, "attrs", {}).get("study", "of this dataset"))), part)(data)


for _part in ("figures", "table", "budget", "findings"):
    setattr(run, _part, partial(_of_dataset, _part))
