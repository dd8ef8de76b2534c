"""Faults of physics and numerics, put into a copy of the code one at a time: which tests notice?

``python tests/mutants/driver.py`` runs all of them, ``--only WORDS`` those whose name or file contains one of
the words, ``--tests PATH ...`` against other tests than the catalogue names, to find what notices. A fault is
*killed* where a test that it names fails, *survived* where all pass, *broken* where pytest could not run
them. ``--by validate`` and ``--by quick`` ask instead whether the cases of ``fem-contact validate`` notice by
themselves: those that call the faulty function, or all where the fault stands outside of functions or in
compiled code. ``--by checks`` counts which of their checks some fault breaks, and names those that none does.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import queue
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("contact_checks", "persson", "fem_contact", "validation")
_CASES = Path(__file__).with_name("validate_cases.py")
_COPIED = (*PACKAGES, "tests", "docs", "pyproject.toml", "README.md", "ARCHITECTURE.md", "CHANGELOG.md")


@dataclass(frozen=True, kw_only=True)
class Mutant:
    """One fault.

    Attributes
    ----------
    name : str
        The physics that is wrong with it.
    file, old, new : str
        In which file what stands, once, and what is put there.
    tests : tuple of str
        Tests, whose names are the claim, or files of tests that notice it.
    kernel : bool
        Whether compiled code changes, so that nothing of the cache may be used.
    survives : str
        Why no test can notice; empty where one must.
    """

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]
    kernel: bool = False
    survives: str = ""

    def applied(self, text: str) -> str:
        """Return the text of the file with the fault."""
        found = text.count(self.old)
        if found != 1:
            raise ValueError(
                f"{self.name}: {self.old!r} stands {found} times in {self.file}, must stand once"
            )
        return text.replace(self.old, self.new)


def catalogue() -> tuple[Mutant, ...]:
    """Return all faults."""
    return tuple(mutant for file in sorted(Path(__file__).parent.glob("*.toml")) for mutant in _read(file))


def _read(file: Path) -> Iterator[Mutant]:
    said = tomllib.loads(file.read_text(encoding="utf-8"))
    groups = said.get("tests", {})
    for entry in said.get("mutant", ()):
        tests = tuple(path for name in entry.pop("tests") for path in groups.get(name, (name,)))
        yield Mutant(tests=tests, **entry)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of one fault: killed, survived or broken; the tests that failed; seconds."""

    mutant: Mutant
    verdict: str
    failed: tuple[str, ...]
    seconds: float
    output: str


@contextmanager
def copied_tree() -> Iterator[Path]:
    """Make a copy of the tree that may be damaged."""
    with tempfile.TemporaryDirectory(prefix="mutants-") as name:
        tree = Path(name) / "tree"
        tree.mkdir()
        leave = shutil.ignore_patterns("__pycache__", "mutants", "*.nbc", "*.nbi")
        for entry in _COPIED:
            source = ROOT / entry
            if source.is_dir():
                shutil.copytree(source, tree / entry, ignore=leave)
            elif source.exists():
                shutil.copy(source, tree / entry)
        yield tree


def run_tests(tree: Path, tests: Sequence[str], *, cache: Path, limit: float = 600) -> tuple[int, str]:
    """Run tests in a tree, and return pytest's exit code with its output."""
    # The results of one fault must not be mistaken for those of another.
    options = [
        "-q",
        "-n",
        "0",
        "-p",
        "no:cacheprovider",
        "-m",
        "not benchmark",
        "-rf",
        "--tb=no",
        "--maxfail=12",
    ]
    return _run(tree, ["-m", "pytest", *options, *tests], cache=cache, limit=limit)


def _run(tree: Path, arguments: Sequence[str], *, cache: Path, limit: float) -> tuple[int, str]:
    environment = os.environ | {"PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(cache)}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"  # a file that changes within a second keeps its bytecode
    environment.pop("PYTEST_ADDOPTS", None)
    command = [sys.executable, "-B", *arguments]
    try:
        done = subprocess.run(
            command, check=False, cwd=tree, env=environment, capture_output=True, text=True, timeout=limit
        )
    except subprocess.TimeoutExpired:
        return 1, f"FAILED within {limit:g} s: nothing came to an end"
    return done.returncode, done.stdout + done.stderr


@dataclass(frozen=True, kw_only=True)
class Cases:
    """What `fem-contact validate` runs: the functions that each case calls, and its seconds."""

    reached: dict[str, frozenset[tuple[str, int]]]
    seconds: dict[str, float]
    checks: dict[str, frozenset[str]]

    @classmethod
    def recorded(cls, tree: Path, *, quick: bool) -> Cases:
        """Run the cases in a sound tree and note what they call."""
        file = tree.parent / "reached.json"
        code, output = _run(tree, [str(_CASES), "record", str(file)], cache=tree.parent / "cache", limit=1800)
        if code:
            raise RuntimeError(f"the cases cannot be recorded: {output[-2000:]}")
        found = {n: f for n, f in json.loads(file.read_text()).items() if f["quick"] or not quick}
        return cls(
            reached={name: frozenset(map(tuple, one["functions"])) for name, one in found.items()},
            seconds={name: one["seconds"] for name, one in found.items()},
            checks={name: frozenset(one["checks"]) for name, one in found.items()},
        )

    def that_call(self, mutant: Mutant, text: str) -> list[str]:
        """Return the cases that the fault can change, the fastest first."""
        line = None if mutant.kernel else _function_of(mutant, text)
        names = [n for n, found in self.reached.items() if line is None or (mutant.file, line) in found]
        return sorted(names, key=self.seconds.__getitem__)


def _function_of(mutant: Mutant, text: str) -> int | None:
    """Return where the innermost function around a fault begins; None outside of functions."""
    pairs = zip(mutant.old, mutant.new, strict=False)
    same = next((k for k, (old, new) in enumerate(pairs) if old != new), 0)
    line = text.count("\n", 0, text.index(mutant.old) + same) + 1
    around = [
        min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.FunctionDef) and node.body[0].lineno <= line <= (node.end_lineno or 0)
    ]
    return max(around, default=None)


def judge(mutant: Mutant, tree: Path, *, tests: Sequence[str] = (), cases: Cases | None = None) -> Outcome:
    """Put a fault into a copy of the tree, run its tests or cases, and take it out again."""
    path, began = tree / mutant.file, time.perf_counter()
    sound = path.read_text(encoding="utf-8")
    fresh = tree.parent / "fresh-cache"
    path.write_text(mutant.applied(sound), encoding="utf-8")
    try:
        cache = fresh if mutant.kernel else tree.parent / "cache"
        if cases is None:
            code, output = run_tests(tree, tests or mutant.tests, cache=cache)
        else:
            chosen = cases.that_call(mutant, sound)
            code, output = _run(tree, [str(_CASES), "run", *chosen], cache=cache, limit=600)
    finally:
        path.write_text(sound, encoding="utf-8")
        shutil.rmtree(fresh, ignore_errors=True)
    failed = tuple(
        re.findall(r"^FAILED (\S+(?: \S+\])?)" if cases is None else r"^FAILED (.*)", output, flags=re.M)
    )
    # A case that crashes ends `validate` with another code, and is noticed, too.
    verdict = {0: "survived", 1: "killed"}.get(code, "broken" if cases is None else "killed")
    return Outcome(
        mutant=mutant, verdict=verdict, failed=failed, seconds=time.perf_counter() - began, output=output
    )


def broken_checks(mutants: Sequence[Mutant], *, only: Sequence[str] = ()) -> Iterator[str]:
    """Break what can be broken, fault by fault; yield a line for each that breaks a check no other did.

    Last those that none breaks: a check that cannot fail is worth nothing.
    """
    with copied_tree() as tree:
        cases = Cases.recorded(tree, quick=True)
        left = {(c, q) for c, named in cases.checks.items() for q in named if not only or c in only}
        count = len(left)
        for mutant in sorted(mutants, key=lambda m: m.kernel):
            path = tree / mutant.file
            sound = path.read_text(encoding="utf-8")
            chosen = [name for name in cases.that_call(mutant, sound) if name in {c for c, _ in left}]
            if not chosen:
                continue
            path.write_text(mutant.applied(sound), encoding="utf-8")
            cache = tree.parent / ("fresh-cache" if mutant.kernel else "cache")
            _, output = _run(tree, [str(_CASES), "every", *chosen], cache=cache, limit=1200)
            path.write_text(sound, encoding="utf-8")
            shutil.rmtree(tree.parent / "fresh-cache", ignore_errors=True)
            broken = {tuple(json.loads(line)) for line in re.findall(r"^BROKEN (.*)$", output, flags=re.M)}
            if broken & left:
                yield f"{len(broken & left):4d} more  {mutant.file}: {mutant.name}"
            left -= broken
        yield f"{count - len(left)} of {count} checks are broken by a fault of the catalogue"
        yield from (f"by none: {case}, {quantity}" for case, quantity in sorted(left))


def run_all(
    mutants: Sequence[Mutant], *, workers: int, tests: Sequence[str] = (), by: str = "tests"
) -> Iterator[Outcome]:
    """Judge faults, several at a time, each worker in its own copy of the tree."""
    with ThreadPoolExecutor(workers) as pool:
        trees: queue.SimpleQueue[Path] = queue.SimpleQueue()

        def one(mutant: Mutant) -> Outcome:
            tree = trees.get()
            try:
                return judge(mutant, tree, tests=tests, cases=cases)
            finally:
                trees.put(tree)

        contexts = [copied_tree() for _ in range(workers)]
        try:
            made = [context.__enter__() for context in contexts]
            cases = None if by == "tests" else Cases.recorded(made[0], quick=by == "quick")
            for tree in made:
                trees.put(tree)
            yield from pool.map(one, mutants)
        finally:
            for context in contexts:
                context.__exit__(None, None, None)


def main() -> int:
    """Run the catalogue, or a part of it; 1 where a fault survived that a test should notice."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", default=[""], help="words of the name or file, any of them")
    parser.add_argument("--tests", nargs="+", default=[], help="run these instead of the named ones")
    parser.add_argument("--by", choices=("tests", "validate", "quick", "checks"), default="tests")
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    chosen = [m for m in catalogue() if any(word in m.name or word in m.file for word in asked.only)]
    if asked.by == "checks":
        lines = []
        for line in broken_checks(chosen, only=asked.tests):
            print(line, flush=True)
            lines.append(line)
        return int(any(line.startswith("by none") for line in lines))
    counts: dict[str, int] = {}
    unexpected = 0
    for outcome in run_all(chosen, workers=asked.workers, tests=asked.tests, by=asked.by):
        mutant, verdict = outcome.mutant, outcome.verdict
        counts[verdict] = counts.get(verdict, 0) + 1
        unexpected += verdict == "broken" or (verdict == "survived") != bool(mutant.survives)
        print(f"{verdict:8s} {outcome.seconds:6.1f} s  {mutant.file}: {mutant.name}", flush=True)
        for test in outcome.failed:
            print(f"           by {test}", flush=True)
        if verdict == "broken":
            print(outcome.output[-600:], flush=True)
    print(", ".join(f"{n} {verdict}" for verdict, n in sorted(counts.items())))
    return 1 if unexpected else 0


if __name__ == "__main__":
    sys.exit(main())
