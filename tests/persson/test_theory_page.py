"""docs/theory.md names where each equation is: the names exist, and no numbered equation is left out."""

import importlib
import re
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "theory.md").read_text(encoding="utf-8")
TABLE = PAGE[PAGE.index("## Equation by equation") : PAGE.index("All in `persson` unless")]


def rows():
    return [line.split("|")[1:-1] for line in TABLE.splitlines() if line.startswith("| ")][1:]


def test_every_name_in_the_table_is_defined():
    for _, _, where in rows():
        home = None
        for name in re.findall(r"`([a-z_]+\.[A-Za-z_.]+|[a-z_A-Z]+|\.[a-z_]+)`", where):
            first, *rest = name.split(".")
            if first in {"fem_contact", "validation"} or f"study `{name}`" in where or "studies" in where:
                continue
            try:
                home = importlib.import_module(f"persson.{first}")
                found = home
            except ModuleNotFoundError:
                assert home is not None, name
                rest = [first] if first else []
                found = home
            for part in rest:
                known = getattr(found, "__dataclass_fields__", {})
                assert hasattr(found, part) or part in known, f"{name}: no {part}"
                found = getattr(found, part, found)


def test_every_numbered_equation_is_in_the_table():
    numbers = set()
    for equation, _, _ in rows():
        for low, high in re.findall(r"(?<![.\d])(\d+)(?:-(\d+))?", re.sub(r"Secs?\. [\d., ]+", "", equation)):
            numbers.update(range(int(low), int(high or low) + 1))
    assert numbers >= set(range(1, 57))
