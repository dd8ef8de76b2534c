"""Numbers in words: significant digits, values with their error."""

from __future__ import annotations

from typing import Any

import numpy as np

__all__ = ["json_ready", "significant", "with_error"]


def json_ready(values: dict[str, Any]) -> dict[str, Any]:
    """Return values with None for NaN, which JSON does not know.

    >>> json_ready({"area": float("nan"), "grid": (2, 3)})
    {'area': None, 'grid': (2, 3)}
    """
    return {k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in values.items()}


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


def with_error(value: float, error: float) -> str:
    """Return a number and its error, the error with two significant digits, both with as many decimals.

    >>> with_error(0.1238876, 0.0000016), with_error(0.12, 0.03), with_error(1.0, 0.0)
    ('0.1238876 +- 0.0000016', '0.120 +- 0.030', '1.0000 +- 0')
    >>> with_error(2.1e-5, 3.2e-8), with_error(13000.0, 420.0)
    ('(2.1000 +- 0.0032)e-05', '13000 +- 420')
    """
    if not np.isfinite(value):
        return "not determinable"
    if not (np.isfinite(error) and error > 0):
        return f"{significant(value, 5)} +- {'0' if error == 0 else 'unknown'}"
    order = int(np.floor(np.log10(max(abs(value), error))))
    power = 0 if -4 <= order < 5 else order
    value, error = value / 10.0**power, error / 10.0**power
    # 0.0996 is 0.10 to two digits: the order is that of the rounded error.
    decimals = min(max(0, 1 - int(np.floor(np.log10(float(f"{error:.1e}"))))), 12)
    text = f"{value:.{decimals}f} +- {error:.{decimals}f}"
    return text if power == 0 else f"({text})e{power:+03d}"
