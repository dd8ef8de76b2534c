"""The reference of the site: a page for each public module."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from typing import Any

PACKAGES = ("fem_contact", "persson")

#: A line of a stub of public names: a name of a module, or a module.
_IMPORT = re.compile(r"^from \.(\w*) import (\w+)", re.MULTILINE)


def modules(package: str) -> dict[str, list[str]]:
    """Return the public modules of a package, each with its public names."""
    stub = Path(importlib.import_module(package).__file__ or "").with_suffix(".pyi")
    names: dict[str, list[str]] = {}
    for module, name in _IMPORT.findall(stub.read_text(encoding="utf-8")):
        if module == "face":  # docs/notebook.md
            continue
        names.setdefault(module or name, []).append(name)
    imported = {module: importlib.import_module(f"{package}.{module}") for module in names}
    return {module: sorted(getattr(imported[module], "__all__", names[module])) for module in sorted(names)}


def on_config(config: Any) -> None:
    """Add the pages of the modules to the navigation."""
    (reference,) = (entry["Reference"] for entry in config.nav if "Reference" in entry)
    for package in PACKAGES:
        reference.append({package: [{name: f"reference/{package}/{name}.md"} for name in modules(package)]})


def on_files(files: Any, config: Any) -> None:
    """Make a page for each module."""
    from mkdocs.structure.files import File  # which the tests do without

    for package in PACKAGES:
        for name, members in modules(package).items():
            page = f"# {package}.{name}\n\n::: {package}.{name}\n    options:\n      members: {members}\n"
            files.append(File.generated(config, f"reference/{package}/{name}.md", content=page))
