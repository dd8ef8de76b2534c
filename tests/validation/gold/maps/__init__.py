"""Where gold numbers are now: one module for each study that was rebuilt, kept by whoever renames or
changes one.

``NAMES`` maps a gold place to another place, a variable of the new dataset, or a function of that dataset.
``CHANGED`` gives the reason for numbers that changed on purpose or went; it stands under *Numbers changed* in
CHANGELOG.md, too. A place is "data.kappa", "table.+- (95 %)", "budget.grid [%]", "figure.NAME.kappa", or a
pattern of such; a figure's number is looked up like that of the dataset. Maps of one case of several stand in
``CASES``, by its name, as pairs of both. What a study says in words is kept to be read and not compared.

::

    NAMES = {
        "data.kappa_error": "kappa_surfaces_error",
        "table.+- (95 %)": lambda d: 1.96 * d.kappa_error,
        "figure.*.persson": "theory",
    }
"""

import importlib
import importlib.util


def maps_of(name):
    """Return the new names of an entry, and what changed on purpose.

    A name is another place, a variable of the new dataset, or a function of that dataset.
    """
    module = f"gold.maps.{name.partition(' ')[0].replace('-', '_')}"
    if importlib.util.find_spec(module) is None:
        return {}, {}
    found = importlib.import_module(module)
    names, changed = getattr(found, "CASES", {}).get(name, ({}, {}))
    return {**found.NAMES, **names}, {**found.CHANGED, **changed}
