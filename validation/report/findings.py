"""What a study or a run found, as data: a form, named values with their intervals, and the rule that decides.

A finding is kept in summary.json as it stands here; its text is made from it and never read back. Where
something is decided (a trend, a ranking, an agreement) the deciding value is named by `by`, the rule
belongs to the kind, and the form says ``{verdict}``: a claim that its interval does not support cannot be
said.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from string import Formatter
from typing import Any

import xarray as xr

from validation.errors import UsageError
from validation.report.places import each
from validation.report.quantities import quantity
from validation.report.values import Value, known, values_of


def _sign(value: Value) -> str:
    """Sign of what its interval excludes from zero; 0 where it does not, ? where there is none."""
    number, error = float(value.value), value.error
    if not math.isfinite(number) or error is None or not math.isfinite(error):
        return "?"
    return "0" if abs(number) <= error else ("+" if number > 0 else "-")


def _equivalent(value: Value) -> str:
    """Whether a change, over the one that counts as none, lies within it with all of its interval."""
    number, error = abs(float(value.value)), value.error or 0.0
    if not math.isfinite(number) or not math.isfinite(error):
        return "?"
    return "within" if number + error < 1 else ("beyond" if number - error >= 1 else "undecided")


_UNDECIDED = "not determinable"

#: Kind: the rule from the deciding value to an outcome, and the words of each outcome unless a finding has
#: its own.
KINDS: dict[str, tuple[Callable[[Value], str] | None, dict[str, str]]] = {
    **dict.fromkeys(
        ("value", "order", "ranking", "threshold", "share", "cost", "refusal", "note"), (None, {})
    ),
    "comparison": (
        _sign,
        {
            "+": "above",
            "-": "below",
            "0": "statistically indistinguishable from",
            "?": "not judged, for lack of an interval, against",
        },
    ),
    "trend": (
        _sign,
        {
            "+": "rises",
            "-": "falls",
            "0": "shows no trend that its interval supports",
            "?": f"has a trend that is {_UNDECIDED}",
        },
    ),
    "agreement": (
        lambda value: {"0": "agree", "?": "?"}.get(_sign(value), "differ"),
        {
            "agree": "agree within their 95 % intervals",
            "differ": "differ by more than their 95 % intervals",
            "?": "have no interval to be judged by",
        },
    ),
    "equivalence": (
        _equivalent,
        {
            "within": "the same",
            "beyond": "not the same",
            "undecided": "the same or not: not decided",
            "?": f"the same or not: {_UNDECIDED}",
        },
    ),
}


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One thing found: of a kind of `KINDS`, a sentence with named values in braces.

    ``{verdict}`` is that of the rule of its kind on the value called `by`, in a row where rows have it, by
    `words` where it has its own; ``{each}`` lists the `rows` in the form `item`, those of one verdict
    together where it begins with that.

    >>> change = Value(value=-0.03, error=0.01)
    >>> found = Finding(
    ...     kind="trend", form="kappa {verdict} by {change:%}.", values={"change": change}, by="change"
    ... )
    >>> found.text
    'kappa falls by (-3.0 +- 1.0) %.'
    >>> rows = [{"load": Value(value=n), "change": replace(change, error=n)} for n in (0.04, 0.01, 0.08)]
    >>> print(Finding(kind="trend", form="kappa {each}.", item="{verdict} at {load}", rows=rows, by="change"))
    kappa shows no trend that its interval supports at 0.04, at 0.08 and falls at 0.01.
    """

    kind: str
    form: str
    values: Mapping[str, Value] = field(default_factory=dict)
    item: str = ""
    rows: tuple[Mapping[str, Value], ...] = ()
    by: str = ""
    words: Mapping[str, str] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """The sentence."""
        printed = list(_with_errors(self.form, self.values))
        for row in self.rows:
            printed += _with_errors(self.item, {**self.values, **row})
        sources = {value.sources for value in printed}
        once = len(printed) > 1 and len(sources) == 1 and "" not in sources

        rule, verdicts = KINDS[self.kind][0], {**KINDS[self.kind][1], **self.words}

        def said(values: Mapping[str, Value]) -> dict[str, Any]:
            plain = {n: replace(v, sources="") if once else v for n, v in values.items()}
            if rule is None or self.by not in values:
                return plain
            return plain | {"verdict": verdicts[rule(values[self.by])]}

        whole = said(self.values)
        # A verdict that rows begin with is said once, with the words up to their first number.
        shared = re.match(r"\{verdict\}([^{]*,|[^{(]*(?=\())?|", self.item)
        assert shared is not None
        cases: dict[str, list[str]] = {}
        for row in self.rows:
            here = whole | said(row)
            printed_row, lead = (form.format(**here) for form in (self.item, shared[0]))
            case = cases.setdefault(lead, [])
            case.append(printed_row.removeprefix(lead).lstrip() if case else printed_row)
        rows = [row for case in cases.values() for row in case]
        apart = "; " if any("," in row for row in rows) else ", "
        listed = " and ".join(filter(None, (apart.join(rows[:-1]), *rows[-1:]))) or "none"
        text = self.form.format(**whole, each=listed)
        if not once:
            return text
        return f"{text.removesuffix('.')} (95 %: {sources.pop()}){'.' if text.endswith('.') else ''}"

    def __str__(self) -> str:
        return self.text

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Outcome of the rule: of the finding, or of each row; empty where nothing is decided."""
        rule = KINDS[self.kind][0]
        decided = (self.values,) if self.by in self.values else self.rows
        return tuple(rule(values[self.by]) for values in decided) if rule and self.by else ()

    def as_json(self) -> dict[str, Any]:
        """Return it as data, with its text for those who read."""
        record: dict[str, Any] = {"kind": self.kind, "text": self.text, "form": self.form}
        plain = [
            {n: value.as_json() for n, value in sorted(row.items())} for row in (self.values, *self.rows)
        ]
        if self.values:
            record["values"] = plain[0]
        if self.rows:
            record |= {"item": self.item, "rows": plain[1:]}
        if self.by:
            record |= {"by": self.by, "outcomes": list(self.outcomes)}
        return record


def _with_errors(form: str, values: Mapping[str, Value]) -> Iterator[Value]:
    for _, name, spec, _ in Formatter().parse(form):
        value = values.get(name or "", Value(value=0.0))
        if value.error and math.isfinite(value.error) and not set(spec or "") & set(".u~"):
            yield value


def finding(
    kind: str,
    form: str,
    data: xr.Dataset | None = None,
    *,
    item: str = "",
    by: str = "",
    words: Mapping[str, str] | None = None,
    **more: Value | xr.DataArray | float | str,
) -> Finding:
    """Return a finding whose values are those of a dataset that its forms name; see `Finding`.

    Its attributes and its numbers without dimensions are values, those that `item` names are rows, one at
    each of their places. Of `more` values plain numbers are exact. A part of the form in brackets is left
    out where a value that it names is not there.
    """
    data = xr.Dataset() if data is None else data
    in_rows = _names(item) | {by}
    named = [v for n, v in data.variables.items() if item and n in in_rows]
    along = dict.fromkeys(str(dim) for variable in named for dim in variable.dims)
    over = tuple(dim for dim in along if data.sizes[dim] != 1) or tuple(along)[:1]
    data = data.squeeze([dim for dim, n in data.sizes.items() if n == 1 and dim not in over])
    said = {n: v for n, v in data.attrs.items() if n in _names(form, item) and n not in data.variables}
    values = {n: _exact(v) for n, v in (said | more).items()}
    form = _OPTIONAL.sub(lambda part: _said(part[1], data, values), form)
    asked = _names(form, item) | {by}
    values = {n: value for n, value in values.items() if known(value.value) or n in asked}
    here = values_of(data, asked.__contains__)
    if kind not in KINDS or ("verdict" in asked and not (by and KINDS[kind][0])):
        raise UsageError(
            f"finding {form!r}: the kind {kind!r} says no verdict, or 'by' names no value that decides"
        )
    if strange := sorted(set(words or {}) - set(KINDS[kind][1])):
        raise UsageError(f"finding {form!r}: {', '.join(strange)}: no outcome of the kind {kind!r}")
    for one in (form, item):
        if one.count("[") != one.count("]") or one != one.strip():
            problem = "a bracket is not closed, or a part of the sentence is missing"
            raise UsageError(f"finding {one!r}: {problem}")
    # The rest need not be sliced at every place.
    shown = data[[n for n in data.data_vars if str(n).removesuffix("_error") in in_rows]]
    places = each(shown, *over) if item else ()
    rows = tuple(
        {n: v for n, v in values_of(p, in_rows.__contains__).items() if n not in here} for p in places
    )
    there = {*here, *values, *(rows[0] if rows else ()), "verdict", "each"}
    absent = sorted(asked - there - {""}) if rows or not item else []
    if absent:
        raise UsageError(f"finding {form!r}: no single number {', '.join(absent)} at a place over {over}")
    values = {**here, **values}
    return Finding(kind=kind, form=form, values=values, item=item, rows=rows, by=by, words=words or {})


#: A part of a form in brackets, with values in it.
_OPTIONAL = re.compile(r"\[([^][]*\{[^][]*)\]")


def _said(part: str, data: xr.Dataset, values: Mapping[str, Value]) -> str:
    for name in _names(part):
        if name not in values and name not in data.variables:
            quantity(name)  # what is no quantity at all is refused
            return ""
        if not known(values[name].value if name in values else data[name].item()):
            return ""
    return part


def _names(*forms: str) -> set[str]:
    """Return the names in braces of some forms."""
    return {name for form in forms for _, name, *_ in Formatter().parse(form) if name}


def _exact(value: Any) -> Value:
    if isinstance(value, Value):
        return value
    return Value(value=value.item() if hasattr(value, "item") else value)


def note(form: str, **values: Value | float | str) -> Finding:
    """Return what a reader should know, such as what of a scene is not used."""
    return finding("note", form, **dict[str, Any](values))


def of_one_surface(data: xr.Dataset) -> list[Finding]:
    """Return the note that a single surface says nothing of others; none where there are several."""
    words = "These are numbers of one surface: how much another of the same spectrum would differ is unknown."
    return [] if data.sizes["surface"] > 1 else [note(words)]


def ranking(form: str, ranked: Mapping[str, Value], between: Callable[[str, str], float]) -> Finding:
    """Return an order of named values, smallest first, in which only what intervals separate is ranked.

    ``{order}`` in the form becomes ``a < b = c``: "=" joins neighbours that differ by less than the interval
    of their difference, half of which `between` returns for two names. Of what is judged by one simulation
    that is less than the intervals of both say.

    >>> told = {"Xu": Value(value=0.13, error=0.02), "Persson": Value(value=0.15, error=0.02)}
    >>> ranking("Distance to the simulation: {order}.", told, lambda *_: 0.0).text
    'Distance to the simulation: Xu 0.130 +- 0.020 < Persson 0.150 +- 0.020.'
    """
    order = sorted(ranked.items(), key=lambda one: float(one[1].value))
    sources, text, last = {value.sources for _, value in order}, "", ""
    for name, value in order:
        if last:
            apart = float(value.value) - float(ranked[last].value)
            text += " < " if apart > between(last, name) else " = "
        # The sentence says once of which sources all are.
        text += f"{name} {replace(value, sources='') if len(order) > 1 == len(sources) else value}"
        last = name
    rows = tuple({"name": Value(value=name), "value": value} for name, value in order)
    return Finding(
        kind="ranking", form=form, values={"order": Value(value=text)}, item="{name} {value}", rows=rows
    )
