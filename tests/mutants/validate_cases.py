"""What `fem-contact validate` notices: which functions its cases call, and whether any of them fails.

``validate_cases.py record FILE`` writes the functions that each case calls and the checks it makes, ``...
run NAME ...`` runs cases until one fails, names it and exits with 1, ``... every NAME ...`` runs all, naming
each check that fails. They import the packages that PYTHONPATH names.
"""

from __future__ import annotations

import json
import multiprocessing
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, FrameType
from typing import Any


def _called(case: Any, tree: str) -> dict[str, Any]:
    """Run a case, and return its seconds and the functions of the packages that it called."""
    from validation.cases import run_cases

    seen: set[CodeType] = set()

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            seen.add(frame.f_code)

    began = time.perf_counter()
    sys.setprofile(note)
    (verdict,) = run_cases([case])
    sys.setprofile(None)
    if not verdict.passed:
        raise SystemExit(f"{case.name} fails without a fault: {verdict.error or verdict.checks}")
    functions = sorted(
        {
            (code.co_filename.removeprefix(tree), code.co_firstlineno)
            for code in seen
            if code.co_filename.startswith(tree)
        }
    )
    checks = [check.quantity for check in verdict.checks]
    seconds = time.perf_counter() - began
    return {"seconds": seconds, "quick": case.quick, "functions": functions, "checks": checks}


def record(file: Path) -> None:
    """Write what each case calls, each in a process of its own, since a kept result is computed once."""
    import validation
    from validation.cases import all_cases

    tree, found = f"{Path(validation.__file__).parents[1]}/", {}
    for case in all_cases():
        with multiprocessing.get_context("fork").Pool(1) as pool:
            found[case.name] = pool.apply(_called_by_name, (case.name, tree))
    file.write_text(json.dumps(found), encoding="utf-8")


def _called_by_name(name: str, tree: str) -> dict[str, Any]:
    from validation.cases import all_cases

    return _called(next(case for case in all_cases() if case.name == name), tree)


def run(names: Sequence[str]) -> int:
    """Run cases in the order of their names given here, until one fails."""
    from validation.cases import all_cases, run_cases

    known = {case.name: case for case in all_cases()}
    for verdict in run_cases(known[name] for name in names):
        if not verdict.passed:
            wrong = [check for check in verdict.checks if not check.passed]
            said = verdict.error or "; ".join(
                f"{check.quantity}: {check.computed:.6g} for {check.reference:.6g} +- {check.tolerance:.2g}"
                for check in wrong
            )
            print(f"FAILED {verdict.case} - {said}")
            return 1
    return 0


def every(names: Sequence[str]) -> int:
    """Run cases, and name all checks that fail; what raises has made no check."""
    from validation.cases import all_cases, run_cases

    known = {case.name: case for case in all_cases()}
    for verdict in run_cases(known[name] for name in names):
        for check in verdict.checks:
            if not check.passed:
                print("BROKEN", json.dumps([verdict.case, check.quantity]), flush=True)
    return 0


if __name__ == "__main__":
    verb, *rest = sys.argv[1:]
    sys.exit(record(Path(rest[0])) if verb == "record" else {"run": run, "every": every}[verb](rest))
