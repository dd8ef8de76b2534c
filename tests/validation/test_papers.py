"""Papers are written out once and cited by key."""

import re
from pathlib import Path

from validation.cases import all_cases
from validation.report.papers import CITED_FOR, PAPERS, cited

ROOT = Path(__file__).parents[2] / "validation"
TEXTS = {path: path.read_text(encoding="utf-8") for path in ROOT.rglob("*.py") if path.name != "papers.py"}


def test_no_paper_is_written_out_beside_the_list():
    volume = re.compile(r"[a-z.] [A-Z]?\d+, \d+ \((18|19|20)\d\d\)")
    assert all(volume.search(PAPERS[key]) for key in ("hertz1882", "persson2006"))
    assert [str(path) for path, text in TEXTS.items() if volume.search(text)] == []


def test_every_paper_of_the_list_is_cited_and_every_key_is_in_it():
    together = "".join(TEXTS.values()) + "".join(text for key, text in CITED_FOR.items() if key not in PAPERS)
    assert [key for key in PAPERS if f"[{key}]" not in together and f'"{key}"' not in together] == []
    keys = set(re.findall(r"\[([a-z_]+(?:\d{4}|_book))\]", together))
    assert keys
    assert keys <= set(PAPERS)
    assert not [case.name for case in all_cases() if "[" in case.source]
    assert cited("[hertz1882]; [nobody1900]") == f"{PAPERS['hertz1882']}; [nobody1900]"
