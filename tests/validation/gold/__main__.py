"""Write gold files again: ``python -m gold [NAME ...]`` in ``tests/validation``, all without a name."""

import sys
import tempfile
import time
from pathlib import Path

from gold.asked import COMPARED, SCENES, STUDIES
from gold.make import compute, write
from validation.execution.bench import Bench

with tempfile.TemporaryDirectory() as place:
    for name in sys.argv[1:] or (*STUDIES, *SCENES, *COMPARED):
        folder = Path(place) / name
        folder.mkdir()
        start = time.process_time()
        record, _ = compute(name, Bench.at(Path(place) / "solves"), folder)
        for of_page in ("misdrawn", "shown", "said", "answers"):  # are kept beside shown.json
            record.pop(of_page)
        path = write(name, record)
        spent = time.process_time() - start
        print(f"{name}: {len(record)} places, {path.stat().st_size} bytes, {spent:.2f} s", flush=True)
