"""Numbers in words: significant digits, values with their error."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from validation.errors import harmless

if TYPE_CHECKING:
    from markupsafe import Markup

_GREEK = {"kappa": "κ", "sigma": "σ", "gamma": "γ", "lambda": "λ", "zeta": "ζ", "alpha": "α"}
_APART = r"(?<![\w-])(?:{})(?![\w-])"
#: How symbols of the field are typed (in text that was made safe for HTML), and how they are set.
_SYMBOLS = (
    (r"h(?:&#39;|')_?rms(?![\w-])", "h\u2032<sub>rms</sub>"),
    (r"\bh_rms(?![\w-])", "h<sub>rms</sub>"),
    (r"\blambda_(short|long)(?![\w-])", r"λ<sub>\1</sub>"),
    (r"\bq_(short|long)(?![\w-])", r"q<sub>\1</sub>"),
    (r"\b([AU])_(pl|el|full|limit)(?![\w-])", r"\1<sub>\2</sub>"),
    (r"\bgamma_eff(?![\w-])", "γ<sub>eff</sub>"),
    (r"\b([Ap])0(?![\w-])", r"\1<sub>0</sub>"),
    (r"\b([Ah])_0(?![\w-])", r"\1<sub>0</sub>"),
    (r"\b(sigma|zeta)_(\w)(?![\w-])", lambda found: f"{_GREEK[found[1]]}<sub>{found[2]}</sub>"),
    (r"\bDelta gamma(?![\w-])", "Δγ"),
    (r"\bdx(?![\w-])", "Δx"),
    (r"(?<=[\w)])\^\(?(-?[\d./]*\d)\)?", r"<sup>\1</sup>"),
    (_APART.format("|".join(_GREEK)), lambda found: _GREEK[found[0]]),
    (r"\+- ?", "±\u00a0"),
    (r"(?<=\d) %", "\u00a0%"),
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


#: The same symbols, as figures set them.
_DRAWN = (
    (r"\bE\* ?h'_?rms(?![\w-])", r"$E^*h'_{rms}$"),
    (r"\bh'_?rms(?![\w-])", r"$h'_{rms}$"),
    (r"\bh_rms(?![\w-])", r"$h_{rms}$"),
    (r"\blambda_(short|long)(?![\w-])", r"$\\lambda_{\1}$"),
    (r"\bq_(short|long)(?![\w-])", r"$q_{\1}$"),
    (r"\bgamma_eff(?![\w-])", r"$\\gamma_{eff}$"),
    (r"\bA/A0(?![\w-])", "$A/A_0$"),
    (r"\b([Ap])_bem(?![\w-])", r"$\1_{BEM}$"),
    (r"\bdx(?![\w-])", r"$\\Delta x$"),
    (r"\b([AU])_(pl|el|full|limit)(?![\w-])", r"$\1_{\2}$"),
    (r"\b([Ap])0(?![\w-])", r"$\1_0$"),
    (r"\bp\*", "$p^*$"),
    (r"\bh'_?rms\(zeta\)", r"$h'_{rms}(\\zeta)$"),
    (r"(?<![\w$\\{(-])(kappa|sigma|gamma|lambda|zeta|alpha|mu|nu)(?![\w-])", r"$\\\1$"),
    (r"\b(zeta|sigma)_(\w)\b", r"$\\\1_{\2}$"),
    (r"\bDelta gamma(?![\w-])", r"$\\Delta\\gamma$"),
    (r"(?<=[\w)}$])\^\(?(-?[\d./]*\d)\)?", r"$^{\1}$"),
)


def mathtext(text: str) -> str:
    """Return a label of a figure with the symbols of the field as in a book.

    >>> mathtext("p* = p0 / (E* h'_rms)")
    "$p^*$ = $p_0$ / ($E^*h'_{rms}$)"
    """
    for typed, drawn in _DRAWN:
        text = re.sub(typed, drawn, text)
    return text


def mathematics(text: str) -> Markup:
    r"""Return a text for HTML with the symbols of the field as in a book; markup in it is shown as it is.

    >>> mathematics("kappa = (A/A0)/p*, 2 +- 1")
    Markup('κ = (A/A<sub>0</sub>)/p*, 2 ±\xa01')
    >>> mathematics("h'_rms < 1, dx^0.51, kappa-against-hurst")
    Markup('h′<sub>rms</sub> &lt; 1, Δx<sup>0.51</sup>, kappa-against-hurst')
    """
    from markupsafe import Markup, escape

    safe = str(escape(harmless(text)))
    for typed, printed in _SYMBOLS:
        safe = re.sub(typed, printed, safe)
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
    rounded = float(f"{value:.{digits - 1}e}")
    order = int(np.floor(np.log10(abs(rounded))))
    if -4 <= order < 5:
        return f"{value:.{max(0, digits - 1 - order)}f}"
    return f"{value:.{digits - 1}e}"


def percent(value: float) -> str:
    """Return a relative number as a percentage with two significant digits.

    >>> percent(0.0312), percent(-0.5), percent(0.00004), percent(float("nan"))
    ('3.1 %', '-50 %', '0.0040 %', 'not determinable')
    """
    if not np.isfinite(value):
        return "not determinable"
    size = abs(100 * value)
    if size == 0:
        return "0 %"
    decimals = max(0, 1 - int(np.floor(np.log10(size))))
    return f"{100 * value:.{decimals}f} %"


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
