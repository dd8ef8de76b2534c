"""Write glossary.md and scene.md, which registries say: ``python docs/assets/generated.py``."""

from __future__ import annotations

import typing
from pathlib import Path

from validation.report.quantities import registry
from validation.scenes.keys import MODE, SWEPT, facts, tables
from validation.units import example_of

_START = """# Keys of a scene

A scene is a file in TOML: a surface, a solid, a load, and the methods that answer.
`fem-contact scenes copy quickstart mine.toml` makes one to change, and `fem-contact explain mine.toml` says
what it would run.

This page lists every key. `fem-contact scenes keys WORD` searches it from a terminal.

- A value with a unit is text: `length = "100 um"`. Plain numbers are in the SI unit that is named.
- On the command line each key is set by `--set`: `--set solid.young='2 GPa'`. Its last word does where
  only one key of the scene has it: `--set young='2 GPa'`.
- What a scene does not list is not computed.
"""
_SWEEP = f"""
## `[sweep]`: the same scene at several values

{SWEPT}:

```toml
[sweep]
load.reduced_pressure = [0.01, 0.03, 0.1]
effects.hardness.hardness = ["1 GPa", "2 GPa"]
mode = "product"  # {MODE}
```
"""


def table_row(*cells: str) -> str:
    """Return a row of a table in Markdown, whose bars are none of the cells'."""
    escaped = (cell.replace("|", "\\|") for cell in cells)
    return f"| {' | '.join(escaped)} |"


def glossary() -> str:
    """Return the page of the documentation that says what every name means."""
    known = registry()
    rows = "\n".join(
        table_row(f"`{name}`", entry["symbol"], entry["words"], entry.get("unit", "1"))
        for name, entry in sorted(known["quantities"].items())
    )
    endings = sorted(known["qualifiers"].items())
    ends = "\n".join(table_row(f"`_{name}`", entry["words"]) for name, entry in endings)
    return f"""# Glossary

Names in datasets, tables, CSV files and on axes. An interval is always 95 %.

| name | symbol | meaning | unit |
|---|---|---|---|
{rows}

A name may end with

| ending | meaning |
|---|---|
{ends}
"""


def scene_page() -> str:
    """Return docs/scene.md."""
    lines = [_START]
    for _, head, table in tables():
        first = typing.cast(str, table.__doc__).partition("\n\n")[0]
        lines += [f"## {head}\n", f"{' '.join(first.split())}\n"]
        lines += ["| key | meaning | default | example |", "|---|---|---|---|"]
        for name, info in table.model_fields.items():
            if name != "kind":
                cells = f"`{name}`", *facts(info), f"`{name} = {example_of(info)}`"
                lines.append(table_row(*cells))
        lines.append("")
    return "\n".join(lines) + _SWEEP


if __name__ == "__main__":
    docs = Path(__file__).parents[1]
    for name, page in (("glossary.md", glossary()), ("scene.md", scene_page())):
        (docs / name).write_text(page, encoding="utf-8")
