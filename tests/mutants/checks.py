"""Which checks of `fem-contact validate` can fail: each must be broken by a fault of the catalogue.

``python tests/mutants/checks.py [WORD ...]`` puts faults in (those with a word in their name or file, else
all), one at a time, first those that may break most, and runs the cases that call the faulty function and
have a check which no fault has broken yet. checks.json keeps which fault breaks which check; at the end
stand the checks that none breaks, and the exit code is 1 where there are any. A check counts as broken where
its number comes and is wrong: a case that ends with an error has judged nothing. Faults of the cases
themselves do not count. Left out are constants outside of functions, and compiled code.
"""

import argparse
import ast
import contextlib
import gc
import importlib
import json
import multiprocessing
import sys
import time
from pathlib import Path
from types import CodeType, FunctionType

import driver
from driver import ROOT

TABLE = Path(__file__).with_name("checks.json")
Function = tuple[str, int]


def in_a_child(work, *arguments, limit):
    """Yield what work yields in a process of its own, until it ends or takes too long for one."""
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)

    def child():
        for value in work(*arguments):
            theirs.send(value)

    process = context.Process(target=child)
    process.start()
    theirs.close()
    with contextlib.suppress(EOFError):
        while ours.poll(limit):
            yield ours.recv()
    process.kill()
    process.join()


def verdict_of(name):
    """Judge one case."""
    from validation.cases import all_cases, run_cases

    return next(run_cases(case for case in all_cases() if case.name == name))


def recorded(name):
    """Run a case without a fault: its seconds, its checks, the functions it calls, what is imported then."""
    functions = set()

    def note(frame, event, _):
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(f"{ROOT}/"):
            functions.add((code.co_filename.removeprefix(f"{ROOT}/"), code.co_firstlineno))

    began = time.perf_counter()
    sys.setprofile(note)
    verdict = verdict_of(name)
    sys.setprofile(None)
    if not verdict.passed:
        raise SystemExit(f"{name} fails without a fault: {verdict.why}")
    quantities = [check.quantity for check in verdict.checks]
    yield {"seconds": time.perf_counter() - began, "checks": quantities, "functions": functions,
           "modules": sorted(sys.modules)}  # fmt: skip


def function_of(sound, changed):
    """Return where the innermost function around the first change begins; None outside of functions."""
    same = next((k for k, (old, new) in enumerate(zip(sound, changed, strict=False)) if old != new), 0)
    line = sound.count("\n", 0, same) + 1
    around = [
        min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
        for node in ast.walk(ast.parse(sound))
        if isinstance(node, ast.FunctionDef) and node.body[0].lineno <= line <= (node.end_lineno or 0)
    ]
    return max(around, default=None)


def put_in(file, changed):
    """Give every function of a file that lives in this process its code in the changed text."""
    codes, waiting = {}, [compile(changed, str(file), "exec", dont_inherit=True)]
    while waiting:
        code = waiting.pop()
        codes[code.co_qualname, code.co_firstlineno] = code
        waiting += [part for part in code.co_consts if isinstance(part, CodeType)]
    for function in gc.get_objects():
        if isinstance(function, FunctionType) and function.__code__.co_filename == str(file):
            code = codes.get((function.__code__.co_qualname, function.__code__.co_firstlineno))
            if code is not None and code.co_freevars == function.__code__.co_freevars:
                function.__code__ = code


def broken_by(file, changed, names):
    """Yield cases with their checks that fail with a fault."""
    put_in(file, changed)
    for name in names:
        yield name, [check.quantity for check in verdict_of(name).checks if not check.passed]


class Coverage:
    """Cases as they run without a fault, and which fault breaks each check."""

    def __init__(self, names, *, known):
        self.cases = {}
        for name in names:
            (self.cases[name],) = in_a_child(recorded, name, limit=900)
            for module in self.cases[name]["modules"]:  # so that no later child imports it anew
                with contextlib.suppress(ImportError):
                    importlib.import_module(module)
        stored = json.loads(TABLE.read_text(encoding="utf-8"))
        self.table = {
            name: {check: fault for check, fault in stored.get(name, {}).items() if check in case["checks"]}
            for name, case in self.cases.items()
        }
        self.others = {name: checks for name, checks in stored.items() if name in {*known} - {*names}}

    def unbroken(self, name):
        """Return the checks of a case that nothing has broken."""
        return [check for check in self.cases[name]["checks"] if not self.table[name].get(check)]

    def reached(self, fault):
        """Return the cases with unbroken checks that call the function of a fault, the fastest first."""
        sound = (ROOT / fault.file).read_text(encoding="utf-8")
        place = fault.file, function_of(sound, fault.applied(sound))
        names = [n for n, case in self.cases.items() if place in case["functions"] and self.unbroken(n)]
        return sorted(names, key=lambda name: self.cases[name]["seconds"])

    def gain(self, names):
        """Return how many checks a second some cases may give."""
        seconds = sum(self.cases[name]["seconds"] for name in names)
        return sum(len(self.unbroken(name)) for name in names) / (1 + seconds)

    def judge(self, fault, names):
        """Put a fault in, run cases, and yield the checks that it is the first to break."""
        changed = fault.applied((ROOT / fault.file).read_text(encoding="utf-8"))
        for name, failed in in_a_child(broken_by, ROOT / fault.file, changed, names, limit=120):
            for check in sorted(set(failed) & set(self.unbroken(name))):
                self.table[name][check] = fault.name
                yield name, check

    def write(self):
        """Write which fault breaks which check; none where there is no word."""
        whole = {
            name: dict.fromkeys(case["checks"], "") | self.table[name] for name, case in self.cases.items()
        }
        text = json.dumps(self.others | whole, indent=1, sort_keys=True)
        TABLE.write_text(text + "\n", encoding="utf-8")


def main():
    """Judge the faults, write the table; 1 where a check is broken by none."""
    from validation.cases import all_cases

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("words", nargs="*", default=[""], help="faults whose name or file has one of these")
    parser.add_argument("--cases", nargs="+", default=[""], help="cases whose name has one of these")
    parser.add_argument("--long", action="store_true", help="cases that take minutes, too")
    parser.add_argument("--anew", action="store_true", help="forget what is known to be broken")
    given = parser.parse_args()
    if given.anew:
        TABLE.write_text("{}\n", encoding="utf-8")
    chosen = [case for case in all_cases() if case.quick or given.long]
    names = [case.name for case in chosen if any(word in case.name for word in given.cases)]
    coverage = Coverage(names, known=[case.name for case in all_cases()])
    faults = [
        fault
        for fault in driver.catalogue()
        if any(word in fault.name or word in fault.file for word in given.words)
        and not (fault.kernel or fault.file.startswith("validation/cases/"))
    ]
    while faults:
        reached = [coverage.reached(fault) for fault in faults]
        k = max(range(len(faults)), key=lambda k: coverage.gain(reached[k]))
        if not reached[k]:
            break
        fault = faults.pop(k)
        for name, check in coverage.judge(fault, reached[k]):
            print(f"{fault.name}: {name}: {check}", flush=True)
        coverage.write()
    left = [(name, check) for name in names for check in coverage.unbroken(name)]
    for pair in left:
        print("broken by no fault: ", *pair)
    total = sum(len(case["checks"]) for case in coverage.cases.values())
    print(f"{total - len(left)} of {total} checks of {len(names)} cases are broken by a fault")
    return 1 if left else 0


if __name__ == "__main__":
    sys.exit(main())
