"""The notebook of the documentation runs from top to bottom, and says what it promises."""

from __future__ import annotations

import json
from pathlib import Path

NOTEBOOK = Path(__file__).parents[2] / "docs" / "studies.ipynb"


def test_the_notebook_runs_and_its_sentences_are_computed(capsys):
    cells = json.loads(NOTEBOOK.read_text())["cells"]
    space: dict[str, object] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), str(NOTEBOOK), "exec"), space)
    printed = capsys.readouterr().out
    assert "kappa in the limit of vanishing spacing" in printed
    assert "Spectra of alpha 3" in printed
    assert space["kappa"].sizes["surface"] == 4
