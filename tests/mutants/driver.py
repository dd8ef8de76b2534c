"""Faults of physics and numerics, put into a copy of the code one at a time: which tests notice?

``python tests/mutants/driver.py`` runs all of them, ``--only WORDS`` those whose name or file contains one of
the words, ``--tests PATH ...`` against other tests than the catalogue names, to find what notices. A fault is
*killed* where a test that it names fails, *survived* where all pass, *broken* where pytest could not run
them.
"""

import argparse
import compileall
import os
import py_compile
import queue
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("contact_checks", "persson", "fem_contact", "validation")
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

    def applied(self, text):
        """Return the text of the file with the fault."""
        found = text.count(self.old)
        if found != 1:
            raise ValueError(
                f"{self.name}: {self.old!r} stands {found} times in {self.file}, must stand once"
            )
        return text.replace(self.old, self.new)


def catalogue():
    """Return all faults."""
    return tuple(mutant for file in sorted(Path(__file__).parent.glob("*.toml")) for mutant in _read(file))


def _read(file):
    said = tomllib.loads(file.read_text(encoding="utf-8"))
    groups = said.get("tests", {})
    for entry in said.get("mutant", ()):
        tests = tuple(path for name in entry.pop("tests") for path in groups.get(name, (name,)))
        yield Mutant(tests=tests, **entry)


def tests_of_audit():
    """Return the tests of the independent reader, each of which a fault of that reader must break."""
    return {
        f"{path.relative_to(ROOT).as_posix()}::{name}"
        for path in (ROOT / "tests/validation").glob("test_audit*.py")
        for name in re.findall(r"^def (test_\w+)", path.read_text(encoding="utf-8"), flags=re.M)
    }


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of one fault: killed, survived or broken; the tests that failed; seconds."""

    mutant: Mutant
    verdict: str
    failed: tuple[str, ...]
    seconds: float
    output: str


@contextmanager
def copied_tree():
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
        # Of the catalogue its list of checks alone, which the cases are held to.
        (tree / "tests/mutants").mkdir()
        shutil.copy(ROOT / "tests/mutants/checks.json", tree / "tests/mutants")
        # Bytecode that knows its source by the text: that of a file with a fault is not taken.
        compileall.compile_dir(tree, quiet=2, invalidation_mode=py_compile.PycInvalidationMode.CHECKED_HASH)
        yield tree


def run_tests(tree, tests, *, cache, limit=600, whole=False):
    """Run tests in a tree, one by one, or the whole suite, and return pytest's exit code with its output."""
    # The results of one fault must not be mistaken for those of another.
    options = ["-q", "-p", "no:cacheprovider", "-rfE", "--tb=no"]
    options += [] if whole else ["-n", "0", "-m", "not benchmark", "--maxfail=12"]
    environment = os.environ | {"PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(cache)}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"  # a file that changes within a second keeps its bytecode
    environment.pop("PYTEST_ADDOPTS", None)
    command = [sys.executable, "-B", "-m", "pytest", *options, *tests]
    try:
        done = subprocess.run(
            command, check=False, cwd=tree, env=environment, capture_output=True, text=True, timeout=limit
        )
    except subprocess.TimeoutExpired:
        return 1, f"FAILED within {limit:g} s: nothing came to an end"
    return done.returncode, done.stdout + done.stderr


def failed_tests(output):
    """Return which tests failed by what pytest said, with all cases where a case has blanks in its name."""
    found = re.findall(r"^(?:FAILED|ERROR) (\S+(?: \S+\])?)", output, flags=re.M)
    return tuple(dict.fromkeys(n if n.endswith("]") else n.partition("[")[0] for n in found))


def judge(mutant, tree, *, tests=()):
    """Put a fault into a copy of the tree, run its tests, and take it out again."""
    path, began = tree / mutant.file, time.perf_counter()
    sound = path.read_text(encoding="utf-8")
    fresh = tree.parent / "fresh-cache"
    path.write_text(mutant.applied(sound), encoding="utf-8")
    try:
        cache = fresh if mutant.kernel else tree.parent / "cache"
        code, output = run_tests(tree, tests or mutant.tests, cache=cache)
    finally:
        path.write_text(sound, encoding="utf-8")
        shutil.rmtree(fresh, ignore_errors=True)
    return Outcome(
        mutant=mutant,
        verdict={0: "survived", 1: "killed"}.get(code, "broken"),
        failed=failed_tests(output),
        seconds=time.perf_counter() - began,
        output=output,
    )


def run_all(mutants, *, workers, tests=()):
    """Judge faults, several at a time, each worker in its own copy of the tree."""
    with ThreadPoolExecutor(workers) as pool:
        trees = queue.SimpleQueue()

        def one(mutant):
            tree = trees.get()
            try:
                return judge(mutant, tree, tests=tests)
            finally:
                trees.put(tree)

        contexts = [copied_tree() for _ in range(workers)]
        try:
            made = [context.__enter__() for context in contexts]
            for tree in made:
                trees.put(tree)
            yield from pool.map(one, mutants)
        finally:
            for context in contexts:
                context.__exit__(None, None, None)


def main():
    """Run the catalogue, or a part of it; 1 where a fault survived that a test should notice."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", default=[""], help="words of the name or file, any of them")
    parser.add_argument("--tests", nargs="+", default=[], help="run these instead of the named ones")
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    chosen = [m for m in catalogue() if any(word in m.name or word in m.file for word in asked.only)]
    counts = {}
    unexpected, left = 0, tests_of_audit()
    for outcome in run_all(chosen, workers=asked.workers, tests=asked.tests):
        mutant, verdict = outcome.mutant, outcome.verdict
        counts[verdict] = counts.get(verdict, 0) + 1
        unexpected += verdict == "broken" or (verdict == "survived") != bool(mutant.survives)
        print(f"{verdict:8s} {outcome.seconds:6.1f} s  {mutant.file}: {mutant.name}", flush=True)
        for test in outcome.failed:
            print(f"           by {test}", flush=True)
            left.discard(test.partition("[")[0])
        if verdict == "broken":
            print(outcome.output[-600:], flush=True)
    print(", ".join(f"{n} {verdict}" for verdict, n in sorted(counts.items())))
    total = len(tests_of_audit())
    if len(left) < total:
        print(f"{total - len(left)} of {total} tests of the audit are broken by a fault")
    return 1 if unexpected else 0


if __name__ == "__main__":
    sys.exit(main())
