"""Faults drawn at random places of all files, put in one at a time: do the tests that run them notice?

``python tests/mutants/drawn.py --seed 61 --count 100 persson fem_contact validation`` draws kinds and places
of mistakes: an operator, a comparison, a constant, an index, a default, a name or a word of like type, a line
lost or swapped with the next. Each is put into a copy of the tree, and tests that run the line are asked
until one fails, then ``validate --quick`` and ``audit``. At last the whole suite runs with all that survived
put in together, and each alone is asked what failed of it. The coverage file of
``pytest --cov=persson --cov=fem_contact --cov=validation --cov-context=test`` says which tests these are.
``drawn.toml`` holds by hand what no test can notice, with the reason.
"""

import argparse
import ast
import os
import random
import re
import shutil
import subprocess
import sys
import tomllib
from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from pathlib import Path

import driver
from driver import PACKAGES, ROOT

_SIGNS = {"Add": "-", "Sub": "+", "Mult": "/", "Div": "*", "Pow": "*", "FloorDiv": "/",
          "Mod": "*", "BitAnd": "|", "BitOr": "&"}  # fmt: skip
_CLAIMS = {"Lt": "<=", "LtE": "<", "Gt": "<", "GtE": ">", "Eq": "!=", "NotEq": "==",
           "Is": "is not", "IsNot": "is", "In": "not in", "NotIn": "in"}  # fmt: skip
_SIMPLE = ast.Assign | ast.AugAssign | ast.AnnAssign | ast.Expr | ast.Return


@dataclass(frozen=True, kw_only=True)
class Fault:
    """Bytes of a file that are replaced by others, and the function in which they stand."""

    file: str
    kind: str
    start: int
    end: int
    old: str
    new: str
    line: int
    scope: tuple[str, ...]

    def applied(self, text):
        """Return the text of the file with the fault."""
        raw = text.encode()
        return (raw[: self.start] + self.new.encode() + raw[self.end :]).decode()

    @property
    def kernel(self):
        """Whether compiled code may change."""
        return "numba" in (ROOT / self.file).read_text(encoding="utf-8")

    @property
    def name(self):
        """Name that stays while other lines move."""
        old, new = (" ".join(text.split()) for text in (self.old, self.new))
        return f"{self.file}:{'.'.join(self.scope)}: {old} -> {new}"


@dataclass(frozen=True, kw_only=True)
class _Scope:
    """Function with its names by type, its words, and the kind that a constant is of there."""

    path: tuple[str, ...] = ()
    names: dict[str, str]
    words: tuple[str, ...] = ()
    stored: set[str]
    constant: str = ""


class _Places:
    """All faults that can be put into one file."""

    def __init__(self, file, raw):
        self.file, self.raw, self.starts = file, raw, [0]
        for row in raw.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(row))
        self.faults = list(self._inside(ast.parse(raw), _Scope(names={}, stored=set())))

    def _text(self, first, last=None):
        return self.raw[slice(*self._span(first, last))].decode()

    def _span(self, first, last=None):
        end = last or first
        start = self.starts[first.lineno - 1] + first.col_offset
        return start, self.starts[end.end_lineno - 1] + end.end_col_offset

    def _inside(self, node, scope):
        for field, value in ast.iter_fields(node):
            if field in {"annotation", "returns", "decorator_list"}:
                continue
            parts = value if isinstance(value, list) else [value]
            for k, part in enumerate(parts):
                if isinstance(part, ast.Expr) and isinstance(part.value, ast.Constant):
                    continue
                if isinstance(part, ast.stmt) and scope.path:
                    yield from self._lines(part, parts[k + 1] if k + 1 < len(parts) else None, scope)
                if isinstance(part, ast.AST):
                    yield from self._visit(part, scope)
                if isinstance(part, ast.stmt):
                    scope.stored.update(_named(part, ast.Store))

    def _lines(self, node, after, scope):
        """Yield a line lost, if its names have a value without it, and two lines swapped that share names."""
        fresh = _named(node, ast.Store) - scope.stored
        if isinstance(node, _SIMPLE | ast.Continue | ast.Break) and not fresh:
            yield self._fault("line lost", scope, "pass", node)
        if isinstance(node, _SIMPLE) and isinstance(after, ast.Assign | ast.AugAssign | ast.Expr):
            used, set_after = _named(after, ast.Load), _named(after, ast.Store)
            shared = _named(node, ast.Store) & used | _named(node, ast.Load) & set_after
            if shared and not fresh & used:
                between = self.raw[self._span(node)[1] : self._span(after)[0]].decode()
                swapped = self._text(after) + between + self._text(node)
                yield self._fault("lines swapped", scope, swapped, node, after)

    def _fault(self, kind, scope, new, first, last=None):
        start, end = self._span(first, last)
        if scope.constant == "default" or (kind == "constant" and scope.constant):
            kind = scope.constant
        return Fault(file=self.file, kind=kind, start=start, end=end, old=self._text(first, last), new=new,
                     line=first.lineno, scope=scope.path)  # fmt: skip

    def _visit(self, node, scope):
        match node:
            case ast.Raise() | ast.JoinedStr() | ast.Assert() | ast.If(test=ast.Name(id="TYPE_CHECKING")):
                return
            case ast.ClassDef():
                scope = replace(scope, path=(*scope.path, node.name))
            case ast.FunctionDef():
                yield from self._function(node, scope)
                return
            case ast.Subscript():
                yield from self._visit(node.value, scope)
                yield from self._visit(node.slice, replace(scope, constant=scope.constant or "index"))
                return
        for kind, new in self._changed(node, scope):
            yield self._fault(kind, scope, new, node)
        yield from self._inside(node, scope)

    def _function(self, node, outer):
        arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
        names = {a.arg: ast.unparse(a.annotation) for a in arguments if a.annotation}
        names = dict.fromkeys(sorted(_named(node, ast.Store)), "local") | names
        words = tuple(sorted({c.value for c in ast.walk(node) if _is_word(c)}))
        stored = {a.arg for a in ast.walk(node.args) if isinstance(a, ast.arg)}
        scope = _Scope(path=(*outer.path, node.name), names=names, words=words, stored=stored)
        yield from self._visit(node.args, replace(scope, constant="default"))
        yield from self._inside(ast.Module(body=node.body, type_ignores=[]), scope)

    def _changed(self, node, scope):
        """Yield what may stand in place of an expression."""
        match node:
            case ast.BinOp() if sign := _SIGNS.get(type(node.op).__name__):
                yield "operator", f"({self._text(node.left)}) {sign} ({self._text(node.right)})"
            case ast.BoolOp():
                word = " or " if isinstance(node.op, ast.And) else " and "
                yield "operator", f"({word.join(f'({self._text(value)})' for value in node.values)})"
            case ast.UnaryOp():
                yield "operator", f"({self._text(node.operand)})"
            case ast.Compare(ops=[claim]):
                left, right = self._text(node.left), self._text(node.comparators[0])
                yield "comparison", f"({left}) {_CLAIMS[type(claim).__name__]} ({right})"
            case ast.Constant(value=bool(value)):
                yield "constant", str(not value)
            case ast.Constant(value=int(value)):
                yield "constant", repr(value + 1)
            case ast.Constant(value=float(value)):
                yield "constant", repr(value * 1.5 or 0.5)
            case ast.Constant() if _is_word(node):
                yield from (("word", repr(other)) for other in scope.words if other != node.value)
            case ast.Name(ctx=ast.Load()) if node.id in scope.names:
                kind = scope.names[node.id]
                others = sorted(n for n, k in scope.names.items() if k == kind and n != node.id)
                yield from (("name", other) for other in others)


def _named(node, context):
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, context)}


def _is_word(node):
    return isinstance(node, ast.Constant) and re.fullmatch("[a-z_]{2,20}", str(node.value)) is not None


def drawn(package, *, seed, count):
    """Draw the kind with equal chance, then the place with equal chance in all files."""
    kinds = defaultdict(lambda: defaultdict(list))
    for path in sorted((ROOT / package).rglob("*.py")):
        for fault in _Places(str(path.relative_to(ROOT)), path.read_bytes()).faults:
            kinds[fault.kind][fault.file, fault.start].append(fault)
    generator, faults = random.Random(f"{seed} {package}"), dict[str, Fault]()
    while len(faults) < count:
        places = kinds[generator.choice(sorted(kinds))]
        fault = generator.choice(places[generator.choice(sorted(places))])
        faults[fault.name] = fault
    return list(faults.values())


class Covering:
    """Which tests ran each line of the packages, by the contexts of a coverage file."""

    def __init__(self, path):
        from coverage import CoverageData  # which the tests alone do without

        data = CoverageData(str(path))
        data.read()
        self.lines = {}
        self.functions = []
        for measured in (name for name in data.measured_files() if name.endswith(".py")):  # no templates
            contexts = data.contexts_by_lineno(measured).items()
            file = next(f"{p}/{measured.partition(f'/{p}/')[2]}" for p in PACKAGES if f"/{p}/" in measured)
            self.lines[file] = {n: [c.partition("|")[0] for c in found if c] for n, found in contexts}
            for node in ast.walk(ast.parse((ROOT / file).read_bytes())):
                if isinstance(node, ast.FunctionDef | ast.ClassDef):
                    inside = range(node.body[0].lineno, (node.end_lineno or node.lineno) + 1)
                    self.functions.append((node.name, file, inside, _identifiers(node)))
        runs = (test for lines in self.lines.values() for found in lines.values() for test in found)
        self.lengths = Counter(runs)
        self.sharing = _sharing()

    def _of(self, file, lines):
        return {test for n in lines for test in self.lines.get(file, {}).get(n, ())}

    def tests(self, fault, count):
        """Return tests that run a line, the most particular first, and some of all others.

        Of a default, a constant of a module or compiled code they are those of what uses it, and so they are
        where few run the line: it may run in a process of its own.
        """
        first, names = fault.line, {(name, fault.file) for name in fault.scope[-1:]}
        found = self._of(fault.file, range(first, first + fault.old.count("\n") + 1))
        if not names:
            tree = ast.parse((ROOT / fault.file).read_bytes())
            names = {(n, fault.file) for part in tree.body if part.lineno <= first
                     for n in _named(part, ast.Store) if first <= (part.end_lineno or 0)}  # fmt: skip
        if fault.kind == "default" or not fault.scope:
            found = set()
        # A fixture runs its lines once, for the first test alone.
        asked = {test.partition("[")[0] for test in found}
        asked = asked.union(*(mates for mates in self.sharing if mates & asked))
        ran = found = found | {test for test in self.lengths if test.partition("[")[0] in asked}
        for _ in range(5):
            if len(found) >= count // 2:
                break
            # A private name is one of its file.
            users = [user for user in self.functions if any(
                (name == user[0] or name in user[3]) and (file == user[1] or not name.startswith("_"))
                for name, file in names)]  # fmt: skip
            found = found | {test for _, file, lines, _ in users for test in self._of(file, lines)}
            names = names | {(name, file) for name, file, *_ in users}
        # The gold numbers of a study tell most of its faults, and what they show of those of its views.
        study = Path(fault.file).stem.removeprefix("_").removesuffix("_views")
        gold = f"test_gold.py::test_the_numbers_are_those_of_the_gold_file[{study}]"

        def order(test):
            return test not in ran, not test.replace("-", "_").endswith(gold), self.lengths[test], test

        ordered = sorted(found, key=order)
        rest = ordered[count // 2 :]
        return ordered[: count // 2] + rest[:: max(1, -(-2 * len(rest) // count))]


def _sharing():
    """Return sets of tests that share what is made once, of each fixture of a module or of the session."""
    sharing = []
    for path in (ROOT / "tests").rglob("test_*.py"):
        functions = [n for n in ast.parse(path.read_bytes()).body if isinstance(n, ast.FunctionDef)]
        for made in functions:
            if re.search("scope=|cache", " ".join(map(ast.unparse, made.decorator_list))):
                names = {made.name}
                for _ in functions:
                    names |= {f.name for f in functions if names & _identifiers(f)}
                file = path.relative_to(ROOT)
                sharing.append({f"{file}::{name}" for name in names if name.startswith("test_")})
    return sharing


def _identifiers(node):
    texts = (
        getattr(part, field, None)
        for part in ast.walk(node)
        for field in ("id", "attr", "arg", "value" if _is_word(part) else "id")
    )
    return {text for text in texts if isinstance(text, str)}


#: What a user would notice who runs no tests.
_MAIN = "from fem_contact.face import main; main()"
_COMMANDS = ["validate --quick -o checks", "run quickstart -o run", "audit run"]


def judge(fault, tree, tests):
    """Return what becomes of a fault: survived, or killed, by which test or command."""
    # What is taken unless it is told, and what the public functions refuse, by which name.
    doors = ["tests/validation/test_defaults.py"]
    doors += [] if fault.file.startswith("validation") else ["tests/test_public_api.py"]
    for portion in filter(None, (tests[:8], tests[8:], doors)):
        outcome = driver.judge(fault, tree, tests=portion)
        if (
            outcome.verdict == "broken"
            and driver.run_tests(tree, portion, cache=tree.parent / "cache")[0] == 0
        ):
            return "killed", "nothing runs"
        for test in outcome.failed or ([""] if outcome.verdict == "killed" else []):
            if not test or driver.run_tests(tree, [test], cache=tree.parent / "cache")[0] == 0:
                return "killed", test or "no end"
    path = tree / fault.file
    sound = path.read_text(encoding="utf-8")
    path.write_text(fault.applied(sound), encoding="utf-8")
    try:
        command = _failing(tree)
    finally:
        path.write_text(sound, encoding="utf-8")
    return ("killed", command) if command else ("survived", "")


def _failing(tree):
    """Run what a user would; return the first command that fails, or leaves nothing."""
    folder = tree.parent / "shown"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    # Compiled code with the fault is kept nowhere else.
    environment = os.environ | {"PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(folder / "cache")}
    for command in _COMMANDS:
        called = [sys.executable, "-B", "-c", _MAIN, *command.split()]
        done = subprocess.run(called, cwd=folder, env=environment, capture_output=True, check=False)
        if done.returncode or not (folder / command.split()[-1] / "report.html").exists():
            return f"fem-contact {command}"
    return ""


def killed_by_suite(faults, tree):
    """Yield faults that the whole suite notices, and by which test; it runs with all of them at once."""
    files = {fault.file: (tree / fault.file).read_text(encoding="utf-8") for fault in faults}
    left = []
    for file, sound in files.items():
        text, start = sound, len(sound.encode())
        for fault in sorted((f for f in faults if f.file == file), key=lambda f: -f.start):
            if fault.end <= start:
                text, start = fault.applied(text), fault.start
            else:
                left.append(fault)
        (tree / file).write_text(text, encoding="utf-8")
    _, output = driver.run_tests(tree, [], cache=tree.parent / "all-cache", limit=7200, whole=True)
    for file, sound in files.items():
        (tree / file).write_text(sound, encoding="utf-8")
    failed = driver.failed_tests(output)
    for fault in (f for f in faults if failed and f not in left):
        for test in driver.judge(fault, tree, tests=failed).failed:
            if driver.run_tests(tree, [test], cache=tree.parent / "cache")[0] == 0:
                yield fault, test
                break
    if left:
        yield from killed_by_suite(left, tree)


def main():
    """Draw, judge, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("packages", nargs="+")
    parser.add_argument("--seed", type=int, default=61)
    parser.add_argument("--count", type=int, default=100, help="faults of each package")
    parser.add_argument("--tests", type=int, default=36, help="how many tests at most")
    parser.add_argument(
        "--coverage", type=Path, default=ROOT / ".coverage", help="which tests run which line"
    )
    parser.add_argument("--only", default="", help="faults whose name contains this")
    given = parser.parse_args()
    excused = tomllib.loads(Path(__file__).with_name("drawn.toml").read_text(encoding="utf-8"))
    covering, counts, survivors = Covering(given.coverage), Counter[str](), list[Fault]()
    with driver.copied_tree() as tree:
        if command := _failing(tree):
            sys.exit(f"{command} fails by itself")
        for package in given.packages:
            for fault in drawn(package, seed=given.seed, count=given.count):
                if given.only in fault.name:
                    verdict, why = judge(fault, tree, covering.tests(fault, given.tests))
                    if verdict == "survived" and fault.name in excused:
                        verdict, why = "equivalent", excused[fault.name]
                    counts[f"{package}: {verdict}"] += 1
                    survivors += [fault] if verdict == "survived" else []
                    said = f"{fault.kind}, line {fault.line} of {fault.name}"
                    print(f"{verdict}, {said}\n    {why}", flush=True)
        for fault, test in killed_by_suite(survivors, tree):
            package = fault.file.partition("/")[0]
            counts[f"{package}: survived"] -= 1
            counts[f"{package}: killed"] += 1
            print(f"killed by the whole suite, {fault.name}\n    {test}", flush=True)
    print(*(f"{entry} {number}" for entry, number in sorted(counts.items())), sep="\n")


if __name__ == "__main__":
    main()
