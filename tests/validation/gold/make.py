"""Gold numbers: what every study and scene gives at small options, computed, stored and read.

``python -m gold NAME ...`` from ``tests/validation`` writes files again, all of them without a name.
"""

import json
import lzma
import re
from fnmatch import fnmatch
from importlib.metadata import version
from pathlib import Path
from unittest.mock import patch

import llvmlite.binding
import numpy as np
from reading_back import misdrawn

from gold.asked import LADDERS, STUDIES, UNSTEADY
from gold.shown import NUMBER, shown_on, steady_answers, steady_findings
from validation.execution.results import Result
from validation.measurements.convergence import Ladders
from validation.scenes.scene import load_scene
from validation.studies import Study, find_study
from validation.studies._outputs import run_study, study_page

FOLDER = Path(__file__).parent / "stored"
#: Longer arrays are stored as every k-th value, their sum and the sum of their squares.
_WHOLE = 1000
_KEPT = 300

# A record is of places such as "data.kappa" or "table.p*", and what is there: dims, numbers or words.


def machine():
    """What the last digits depend on: a processor by its instructions, for machines rename theirs."""
    libraries = {name: version(name) for name in ("numpy", "scipy", "numba", "ducc0")}
    return {"processor": llvmlite.binding.get_host_cpu_name(), **libraries}


def options_of(name, folder, **changed):
    """Return the study of an entry, what it is asked, and what its ladders are without options for them."""
    study, told = find_study(name.partition(" ")[0]), {**STUDIES[name], **changed}
    if "scene" in told:
        path = folder / "mine.toml"
        path.write_text(told["scene"], encoding="utf-8")
        told["scene"] = load_scene(str(path))
    return study, study.options(**told), LADDERS if name.endswith("with ladders") else {}


def new_numbers(name, bench, folder):
    """Return the numbers of a study; views are made from them."""
    study, options, small = options_of(name, folder)
    with patch.dict(Ladders.__init__.__kwdefaults__, small):
        return study.compute(options, bench=bench)


def leave_study(name, data, folder, *, bench, report):
    """Leave in a folder what a study makes of numbers that are known."""
    study, options, _ = options_of(name, folder)
    with patch.object(Study, "compute", lambda *_, **__: data):
        run_study(study, options, folder, bench=bench, report=report)
    return folder


def compute(name, bench, folder, *, known=None):
    """Return the record of an entry, and the dataset in which renamed numbers are looked up.

    It is computed anew, but for the numbers of a study that `known` has.
    """
    if name not in STUDIES:
        from gold.scenes import of_scene

        return of_scene(name, bench, folder)
    data = known(name) if known else new_numbers(name, bench, folder)
    study, options, _ = options_of(name, folder)
    asked = {"kind": "study", "name": study.name, "settings": options.record()}
    page = study_page(Result(**asked, store=folder, data=data), figures=True)
    record, odd = dict(_of_dataset("data", data)), []
    for part, table in (("table", page.records.get("table")), ("budget", page.budget)):
        if table is not None:
            record |= _of_table(part, table.columns, table.rows)
    for drawing in page.figures:
        record |= _of_dataset(f"figure.{drawing.name}", drawing.data)
        odd += misdrawn(drawing, data)
    odd += [f"no sentence: {text}" for text in page.findings if not text.endswith(".")]
    odd += _ill_said(page.summary["findings"])
    record |= _of_words("findings", page.findings)
    return {**_steady(name, record), **of_page(name, page, odd)}, data


def _ill_said(findings):
    """Say which forms begin like another's, run two sentences together, or leave out what decides."""
    said = [(found["form"], found["kind"]) for found in findings]
    for form, kind in said:
        if any(form.startswith(other[0]) for other in said if other != (form, kind)):
            yield f"begins like another: {form}"
        if re.search(r"\.[^\W\d]", form):
            yield f"sentences that run together: {form}"
    for found in findings:
        empty = "{each}" in found["form"] and not found.get("rows")
        if found.get("by") and not empty and "{verdict}" not in found["form"] + found.get("item", ""):
            yield f"says no verdict: {found['form']}"


def of_page(name, page, odd):
    """Record what a page shows, the numbers of its findings, and what is wrong on it."""
    return {
        "shown": {"words": shown_on(name, page)},
        "said": _steady(name, dict(_of_findings(name, page))),
        "answers": dict(_of_answers(name, page)),
        "misdrawn": {"words": odd},
    }


def _of_findings(name, page):
    for k, found in enumerate(steady_findings(name, page)):
        rows = [row for row in (found.get("values"), *found.get("rows", ())) if row]
        for value in dict.fromkeys(value for row in rows for value in row):
            told = [row[value] for row in rows if value in row]
            numbers = [number for one in told for number in (one["value"], one.get("error"))]
            yield f"finding {k} ({found['kind']}).{value}", _entry(("row",), numbers)


def _of_answers(name, page):
    for card in steady_answers(name, page):
        printed = map(float, NUMBER.findall(f"{card.answer} {card.basis}"))
        # One digit of what rounding leaves is another one elsewhere.
        numbers = [number if abs(number) >= 1e-3 else 0.0 for number in printed]
        yield f"answer: {card.question}", _entry(("number",), numbers)


def of_dataset(name, data):
    """Record the dataset that a run or a sweep left."""
    return _steady(name, dict(_of_dataset("data", data)))


def _steady(name, record):
    """Leave out what two runs do not share: times, and what follows from them."""
    out = (*UNSTEADY["*"], *UNSTEADY.get(name.partition(" ")[0], ()))

    def kept(place):
        return not any(fnmatch(place, pattern) for pattern in out)

    steady = {place: entry for place, entry in record.items() if kept(place)}
    for place, entry in steady.items():
        if "printed" in entry:
            said = zip(entry["words"], entry["printed"], strict=True)
            pairs = [(text, printed) for text, printed in said if kept(f"{place}: {text}")]
            entry["words"], entry["printed"] = [text for text, _ in pairs], [found for _, found in pairs]
    return steady


def _of_dataset(part, data):
    for name, variable in data.variables.items():
        yield f"{part}.{name}", _entry(variable.dims, variable.values, variable.attrs)
    for name, value in data.attrs.items():
        yield f"{part}@{name}", _entry((), value)


def _of_table(part, columns, rows):
    return {f"{part}.{title}": _entry(("row",), [row[k] for row in rows]) for k, title in enumerate(columns)}


def _of_words(part, sentences):
    """Sentences as they are read; the numbers in them beside them, as printed."""
    said = list(sentences)
    found = [[float(number) for number in NUMBER.findall(text)] for text in said]
    return {part: {"dims": ["sentence"], "words": said, "printed": found}}


def _entry(dims, values, attrs=None):
    """Return numbers or words with their dims, ready for JSON; words among numbers are kept beside NaN."""
    array = np.asarray(values, dtype=object) if isinstance(values, list | tuple) else np.asarray(values)
    entry = {"dims": list(dims), "shape": list(array.shape)}
    if attrs:
        entry["attrs"] = {key: value for key, value in attrs.items() if isinstance(value, str)}
    flat = array.ravel()
    if array.dtype.kind in "OUS":
        words = [None if _is_number(item) else str(item) for item in flat]
        if any(word is not None for word in words):
            entry["words"] = words
        flat = np.array([np.nan if item is None or not _is_number(item) else item for item in flat], float)
    if entry.get("words") and None not in entry["words"]:
        return entry
    return entry | numbers_of(flat)


def _is_number(item):
    return item is None or (isinstance(item, float | int | np.number) and not isinstance(item, bool))


def numbers_of(flat):
    """Return numbers as they are stored: all of them, or every k-th with two sums."""
    flat = np.asarray(flat, dtype=float).ravel()
    if flat.size <= _WHOLE:
        return {"numbers": flat.tolist()}
    every = -(-flat.size // _KEPT)
    sums = [float(np.nansum(flat)), float(np.nansum(flat**2)), int(np.isnan(flat).sum())]
    return {"numbers": flat[::every].tolist(), "size": flat.size, "every": every, "sums": sums}


def write(name, record):
    """Store the record of an entry."""
    FOLDER.mkdir(exist_ok=True)
    path = FOLDER / f"{name.replace(' ', '-')}.json.xz"
    text = json.dumps({"name": name, "machine": machine(), "record": record}, indent=0)
    path.write_bytes(lzma.compress(text.encode(), preset=9 | lzma.PRESET_EXTREME))
    return path


def read(name):
    """Return the stored record of an entry, with the machine it was computed on."""
    path = FOLDER / f"{name.replace(' ', '-')}.json.xz"
    return dict(json.loads(lzma.decompress(path.read_bytes())))
