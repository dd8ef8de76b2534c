"""What a page shows, by the names of its variables: which stand in tables, on which axes, in which sentences.

Of the answers on top the words are held as well, and what is explained of a scene before it runs.

``python -m gold.shown NAME ...`` from ``tests/validation`` writes shown.json and said.json.xz again, all
without a name.
"""

import json
import lzma
import re
import sys
import tempfile
from pathlib import Path
from string import Formatter

from gold.asked import COMPARED, SCENES, STUDIES, UNSTEADY
from validation.comparison.explain import explain
from validation.scenes.scene import builtin_scenes
from validation.scenes.sweep import load_asked

STORED = Path(__file__).parent / "shown.json"
#: Numbers of the findings, with their errors, and those printed in the answers on top.
SAID = Path(__file__).parent / "said.json.xz"
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")


def shown_on(name, page):
    """Say it of a page: its head, and a line without wording for each table, sentence and mark."""
    lines = [_bare(page.lead), f"seeds: {page.seeds}"]
    lines.append(f"cites: {'; '.join(paper.partition(',')[0] for paper in page.papers)}")
    lines += [_bare(f"{card.question} {card.answer}; {card.basis}") for card in steady_answers(name, page)]
    for file, table in page.summary["tables"].items():
        columns = [f"{c['name']}{c['at'] or ''}" for c in table.get("columns", ())] or table["names"]
        lines.append(f"table {file}: along {', '.join(table.get('rows', ()))}: {', '.join(columns)}")
    lines.append(f"budget: {', '.join(page.summary.get('budget', ()))}")
    for drawing in page.figures:
        marks = {id(one.mark): one for one in drawing.drawn}.values()
        lines += [f"figure {drawing.name}: {_mark(one)}" for one in marks]
        lines += [
            f"figure {drawing.name}: {told}" for told in re.findall(r"\d+ of \d+ points", drawing.caption)
        ]
        limits = dict.fromkeys((panel.bottom, panel.top, panel.right) for panel in drawing.panels)
        for ends in limits:
            if ends == (None, None, None):
                continue
            told = [None if end is None else float(f"{end:.3g}") for end in ends]
            lines.append(f"figure {drawing.name}: bottom, top, right {told}")
    for found in steady_findings(name, page):
        names = [part[1] for form in (found["form"], found.get("item", "")) for part in _parsed(form)]
        lines.append(f"{found['kind']} by {found.get('by', '')}: {', '.join(names)}")
        lines[-1] += f" {found['outcomes']}" if "outcomes" in found else ""
    return lines


def explained(scene):
    """Say what is explained of a scene of the library before it runs, but for how long on this machine."""
    parts = explain(load_asked(scene)).parts()
    return [part for part in parts if isinstance(part, str) and "this machine" not in part]


def _bare(text):
    return NUMBER.sub("#", text)


def _unsteady(name):
    return any("findings" in place for place in UNSTEADY.get(name.partition(" ")[0], ()))


def steady_answers(name, page):
    """Return those on top of a page that are the same another day."""
    return [card for card in page.answers if not _unsteady(name) and "cost" not in card.question.lower()]


def steady_findings(name, page):
    """Return those that are the same another day: which way of a run is the cheapest is not."""
    if _unsteady(name):
        return []
    costs = name.startswith("scene")
    return [found for found in page.summary["findings"] if not costs or found["kind"] != "cost"]


def _parsed(form):
    return [part for part in Formatter().parse(form) if part[1] is not None]


def _mark(one):
    mark, told = one.mark, {}
    for key in ("by", "at", "where", "look", "label", "joined", "steps", "high", "rows", "symmetric"):
        if value := getattr(mark, key, None):
            told[key] = {n: str(v) for n, v in value.items()} if key == "where" else value
    if title := one.axes.get_title():
        told["title"] = title
    scales = one.axes.get_xscale(), one.axes.get_yscale()
    return f"{type(mark).__name__} {mark.y} over {one.x} {told}, {', '.join(scales)}"


def read_said():
    """Return the stored numbers of findings and answers by entry and place."""
    return dict(json.loads(lzma.decompress(SAID.read_bytes())))


def differences(name, lines):
    """Say what was shown and is not, and what is shown now."""
    known = json.loads(STORED.read_text(encoding="utf-8"))[name]
    yield from (f"shown no more: {line}" for line in known if line not in lines)
    yield from (f"newly shown: {line}" for line in lines if line not in known)
    if sorted(lines) == sorted(known) and lines != known:
        yield f"shown in another order: {lines}"


def main():
    """Write it again where a change is meant."""
    from gold.make import compute
    from validation.execution.bench import Bench

    known, said = {}, {"said": {}, "answers": {}}
    if sys.argv[1:]:
        known, said = json.loads(STORED.read_text(encoding="utf-8")), read_said()
    with tempfile.TemporaryDirectory() as place:
        for name in sys.argv[1:] or (*STUDIES, *SCENES, *COMPARED):
            folder = Path(place) / name
            folder.mkdir()
            record = compute(name, Bench.at(Path(place) / "solves"), folder)[0]
            known[name] = record["shown"]["words"]
            for part, numbers in said.items():
                numbers[name] = record[part]
            print(name, len(known[name]), len(said["said"][name]), flush=True)
    known |= {f"explain {scene}": explained(scene) for scene in builtin_scenes()}
    STORED.write_text(json.dumps(known, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    text = json.dumps(said, indent=0, sort_keys=True)
    SAID.write_bytes(lzma.compress(text.encode(), preset=9 | lzma.PRESET_EXTREME))


if __name__ == "__main__":
    main()
