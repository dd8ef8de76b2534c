"""Studies: one module per question.

A study module has

``QUESTION``
    what it answers, in a line;
``Options``
    its settings, a pydantic table with a description of each;
``run(scene=None, *, bench=None, **options) -> xarray.Dataset``
    the numbers, from cases that the bench stores and resumes;
``findings(dataset) -> tuple[str, ...]``
    what they say, every word computed;
``table(dataset) -> Table``
    the same as rows;
``figures(dataset) -> dict[str, Figure]``
    from `validation.plots_studies`.

The package discovers them by file name: a new study is one new file.
"""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType

__all__ = ["find_study", "study_names"]

#: Modules of this package that are tools of the studies and no studies themselves.
_TOOLS = frozenset({"common", "grid_roughness", "measurement", "output"})


def study_names() -> tuple[str, ...]:
    """Return the names of the studies as the command line spells them."""
    names = (module.name for module in pkgutil.iter_modules(__path__))
    return tuple(sorted(name.replace("_", "-") for name in names if name not in _TOOLS))


def find_study(name: str) -> ModuleType:
    """Import a study by name.

    Raises
    ------
    UsageError
        For an unknown name.
    """
    from validation.errors import UsageError

    if name.replace("_", "-") not in study_names():
        raise UsageError(f"no study {name!r}; there are: {', '.join(study_names())}")
    return importlib.import_module(f"{__name__}.{name.replace('-', '_')}")
