"""Gold numbers beside those of today: by meaning, through a map of names."""

from fnmatch import fnmatch

import numpy as np
import xarray as xr

from gold import shown
from gold.asked import ROUNDING
from gold.make import compute, machine, numbers_of, read
from gold.maps import maps_of

#: On the machine of the gold files the same operations run in the same order.
RTOL_HERE = 1e-12
#: Elsewhere solves end where their residuals, 1e-8 of p |g| and below, are small enough, and areas,
#: energies and differences of areas between grids follow: a hundred times that.
RTOL_ELSEWHERE = 1e-6
#: Of two digits the last may be another one.
_RTOL_PRINTED = 0.1


def disagreements(name, bench, folder, *, known=None):
    """Compute an entry anew, but for what is `known`, and say what differs from its gold file."""
    gold = read(name)
    here = gold["machine"] == machine()
    new, data = compute(name, bench, folder, known=known)
    rtol = RTOL_HERE if here else RTOL_ELSEWHERE
    record = gold["record"] if here else _without_rounding(name, gold["record"])
    odd = new.pop("misdrawn")["words"]
    odd += shown.differences(name, new.pop("shown")["words"])
    for part, part_rtol in (("said", RTOL_ELSEWHERE), ("answers", _RTOL_PRINTED)):
        said = _without_rounding(name, shown.read_said()[part][name])
        odd += differences(name, said, new.pop(part), data, rtol=part_rtol)
    return [*differences(name, record, new, data, rtol=rtol), *odd]


def _without_rounding(name, record):
    """Leave out what is rounding."""
    return {p: e for p, e in record.items() if not any(fnmatch(f"{name}: {p}", part) for part in ROUNDING)}


def differences(name, gold, new, data, *, rtol):
    """Yield the gold places whose numbers are not there now, or are others.

    Parameters
    ----------
    name : str
        Of the entry.
    gold, new : dict
        Records by place: data.kappa, table.p*, budget.grid [%], figure.area.kappa, findings.
    data : xarray.Dataset
        Where renamed numbers are looked up.
    rtol : float
        Of each number, or of the largest of its array where that is more than a thousandth of it.
    """
    names, changed = maps_of(name)
    for place, entry in gold.items():
        # Words are kept to be read.
        if "numbers" not in entry or any(fnmatch(place, pattern) for pattern in changed):
            continue
        # Figures of what was rebuilt show variables of the dataset: they are where those are.
        at = place
        if place.startswith("figure.") and place not in new:
            at = f"data@{place.split('@')[1]}" if "@" in place else f"data.{place.rpartition('.')[2]}"
        found = _found(place if place in names else at, entry, names, new, data)
        if found is None:
            yield f"{place}: is gone; say in gold/maps where it is now"
            continue
        yield from (f"{place}: {why}" for why in _apart(entry, found, rtol=rtol))
        if found.get("dims", entry["dims"]) != entry["dims"]:
            yield f"{place}: along {', '.join(entry['dims'])}, now along {', '.join(found['dims'])}"


def _found(place, entry, names, new, data):
    """Look a gold place up: through the map, by its own name, and a figure's number in the dataset."""
    look = next((names[key] for key in (place, *names) if key in names and fnmatch(place, key)), None)
    if look is None and place in new:
        return new[place]
    variable = place.rpartition(".")[2]
    if look is None and place.startswith(("figure.", "data.")):
        look = names.get(f"data.{variable}", variable if variable in data.variables else None)
    if look is None:
        return None
    if isinstance(look, str) and look in new:
        return new[look]
    value = look(data) if callable(look) else data[look]
    if isinstance(value, xr.DataArray):
        value = value.squeeze()
        dims = [dim for dim in entry["dims"] if dim in value.dims]
        if set(dims) == set(value.dims):
            value = value.transpose(*dims)
    flat = np.asarray(value).ravel()
    return {"words": [str(item) for item in flat]} if flat.dtype.kind in "OUS" else numbers_of(flat)


def _apart(gold, new, *, rtol):
    """Say how the numbers of two entries differ; NaN equals NaN."""
    a, b = (np.array(entry.get("numbers", ()), dtype=float) for entry in (gold, new))
    if a.shape != b.shape or gold.get("size") != new.get("size"):
        yield f"{gold.get('size', a.size)} numbers, now {new.get('size', b.size)}"
        return
    # A number far below the others of its array has no more digits than they have.
    finite = np.abs(a[np.isfinite(a)])
    floor = 1e-3 * (finite.max() if finite.size else 0.0)
    with np.errstate(invalid="ignore"):
        same = (a == b) | (np.isnan(a) & np.isnan(b)) | (np.abs(a - b) <= rtol * np.maximum(np.abs(a), floor))
    if not same.all():
        k = int(np.flatnonzero(~same)[0])
        yield f"{int((~same).sum())} of {a.size} numbers differ; number {k} was {a[k]!r}, is {b[k]!r}"
    for was, now in zip(gold.get("sums", ()), new.get("sums", ()), strict=True):
        # Rounding errs to both sides; what ends elsewhere may err to one.
        alike = gold["sums"][1] * (1 if rtol <= RTOL_HERE else gold["size"])
        scale = max(abs(was), np.sqrt(alike))
        if abs(was - now) > rtol * scale:
            yield f"the sums over all {gold['size']} numbers differ: {was!r}, now {now!r}"
