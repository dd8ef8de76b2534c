"""What is held: numbers, what is shown, claims, judgements, defaults."""

import json


def write_lines(path, entries):
    """Write a table as JSON, a line for each entry."""
    lines = (f"{json.dumps(name)}: {json.dumps(entry, sort_keys=True)}" for name, entry in entries.items())
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
