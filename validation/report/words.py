"""Numbers in words: significant digits, values with their error."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.errors import harmless

if TYPE_CHECKING:
    from markupsafe import Markup

_GREEK = {"kappa": "κ", "sigma": "σ", "gamma": "γ", "lambda": "λ", "zeta": "ζ", "alpha": "α"}
_NAMES, _END = "|".join(_GREEK), r"(?![\w-])"
#: How symbols of the field are typed, and how pages (text that was made safe for HTML) and figures set them.
_SYMBOLS: tuple[tuple[str, Any, str | None], ...] = (
    (rf"\bE\* ?h'_?rms{_END}", None, r"$E^*h'_{rms}$"),
    (rf"\bh(?:&#39;|')_?rms{_END}", "h\u2032<sub>rms</sub>", r"$h'_{rms}$"),
    (rf"\bh_rms{_END}", "h<sub>rms</sub>", r"$h_{rms}$"),
    (rf"\blambda_(short|long){_END}", r"λ<sub>\1</sub>", r"$\\lambda_{\1}$"),
    (rf"\bq_(short|long){_END}", r"q<sub>\1</sub>", r"$q_{\1}$"),
    (rf"\bgamma_eff{_END}", "γ<sub>eff</sub>", r"$\\gamma_{eff}$"),
    (rf"\bA/A0{_END}", None, "$A/A_0$"),
    (rf"\b([Ap])_bem{_END}", None, r"$\1_{BEM}$"),
    (rf"\b([AU])_(pl|el|full|limit){_END}", r"\1<sub>\2</sub>", r"$\1_{\2}$"),
    (rf"\b([Ap])0{_END}", r"\1<sub>0</sub>", r"$\1_0$"),
    (rf"\b([Ah])_0{_END}", r"\1<sub>0</sub>", None),
    (r"\bp\*", None, "$p^*$"),
    (rf"\bDelta gamma{_END}", "Δγ", r"$\\Delta\\gamma$"),
    (rf"\b(sigma|zeta)_(\w){_END}", lambda found: f"{_GREEK[found[1]]}<sub>{found[2]}</sub>", r"$\\\1_{\2}$"),
    (rf"\bdx{_END}", "Δx", r"$\\Delta x$"),
    (r"(?<=[\w)}$])\^(\()?(-?[\d./]*\d)(?(1)\))", r"<sup>\2</sup>", r"$^{\2}$"),
    (rf"(?<![\w-])({_NAMES}){_END}", lambda found: _GREEK[found[0]], None),
    (rf"(?<![\w$\\{{(-])({_NAMES}|mu|nu){_END}", None, r"$\\\1$"),
    (r"\+- ?", "±\u00a0", None),
    (r"(?<=\d) %", "\u00a0%", None),
)


def json_ready(value: Any) -> Any:
    """Return data, nested or not, with None for NaN and infinity, which JSON does not know.

    >>> json_ready({"area": float("nan"), "grid": (2, 3), "errors": [0.1, float("inf")]})
    {'area': None, 'grid': (2, 3), 'errors': [0.1, None]}
    """
    if isinstance(value, dict):
        return {key: json_ready(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(map(json_ready, value))
    return None if isinstance(value, float) and not np.isfinite(value) else value


def mathtext(text: str) -> str:
    """Return a label of a figure with the symbols of the field as in a book.

    >>> mathtext("p* = p0 / (E* h'_rms)")
    "$p^*$ = $p_0$ / ($E^*h'_{rms}$)"
    """
    for typed, _, drawn in _SYMBOLS:
        text = text if drawn is None else re.sub(typed, drawn, text)
    return text


def mathematics(text: str) -> Markup:
    r"""Return a text for HTML with the symbols of the field as in a book; markup in it is shown as it is.

    >>> mathematics("kappa = (A/A0)/p*, 2 +- 1")
    Markup('κ = (A/A<sub>0</sub>)/p*, 2 ±\xa01')
    >>> mathematics("h'_rms < 1, dx^(2/3), kappa-against-hurst, 1/(ohm m^2)")
    Markup('h′<sub>rms</sub> &lt; 1, Δx<sup>2/3</sup>, kappa-against-hurst, 1/(ohm m<sup>2</sup>)')
    """
    from markupsafe import Markup, escape

    safe = str(escape(harmless(text)))
    for typed, printed, _ in _SYMBOLS:
        safe = safe if printed is None else re.sub(typed, printed, safe)
    # Nothing but the tags above was added to what `escape` made safe.
    return Markup(safe)


def significant(value: float, digits: int = 4) -> str:
    """Return a number with that many significant digits, without an exponent between 1e-4 and 1e5.

    >>> significant(12904.486), significant(0.000161234), significant(0.5), significant(float("nan"))
    ('12904', '0.0001612', '0.5000', '')
    """
    if not np.isfinite(value):
        return ""
    if value == 0:
        return "0"
    scientific = f"{value:.{digits - 1}e}"
    order = int(scientific.partition("e")[2])
    return f"{value:.{max(0, digits - 1 - order)}f}" if -4 <= order < 5 else scientific


def percent(value: float) -> str:
    """Return a relative number as a percentage with two significant digits.

    >>> percent(0.0312), percent(-0.5), percent(0.00004), percent(float("nan"))
    ('3.1 %', '-50 %', '0.0040 %', 'not determinable')
    """
    return f"{significant(100 * value, 2)} %" if np.isfinite(value) else "not determinable"


def with_error(value: float, error: float) -> str:
    """Return a number and its error, the error with two significant digits, both with as many decimals.

    >>> with_error(0.1238876, 0.0000016), with_error(0.12, 0.03), with_error(1.0, 0.0)
    ('0.1238876 +- 0.0000016', '0.120 +- 0.030', '1.0000 +- 0')
    >>> with_error(2.1e-5, 3.2e-8), with_error(13000.0, 420.0)
    ('(2.1000 +- 0.0032)e-05', '13000 +- 420')
    """
    from uncertainties import ufloat

    if not np.isfinite(value):
        return "not determinable"
    if error < 1e-10 * abs(value):  # rounding
        error = 0.0
    if not (np.isfinite(error) and error > 0):
        return f"{significant(value, 5)} +- {'0' if error == 0 else 'unknown'}"
    plain = 1e-4 <= max(abs(value), error) < 1e5
    return format(ufloat(value, error), ".2uf" if plain else ".2ue").replace("+/-", " +- ")
