"""A theory of the user's own: functions of a module, by name."""

import importlib
import importlib.util
import inspect
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Self

import numpy as np

from validation.arrays import Array
from validation.errors import UsageError
from validation.registry import with_own_folder
from validation.theories.base import Rough, Theory

#: What functions of a module are asked for, and by which keywords they say what they need.
_QUANTITIES = ("area", "pressure_distribution", "mean_gap", "elastic_energy")
_TOLD = ("contact_modulus", "moments", "spectrum")


class OwnTheory(Theory):
    """Functions of pressure [Pa] that take by name what they need of contact_modulus, moments, spectrum.

    Parameters
    ----------
    label : str
    functions : mapping of str to callable
        By the names of the methods of `Theory`; ``area`` is there.
    """

    name = "own"

    def __init__(self, label: str, functions: Mapping[str, Callable[..., Any]]) -> None:
        self.label = label
        for quantity, function in functions.items():
            setattr(self, quantity, partial(self._called, quantity, function))

    @classmethod
    def named(cls, text: str) -> Self | None:
        """Return the functions of ``module:function``, an area, or of ``module``; None without such a module.

        A UsageError for a module that cannot be imported or has no such function.
        """
        home, colon, name = text.partition(":")
        module = _module(home)
        if module is None:
            return None
        names = {name: "area"} if colon else {quantity: quantity for quantity in _QUANTITIES}
        values = {kind: f for have, kind in names.items() if callable(f := getattr(module, have, None))}
        if "area" not in values:
            raise UsageError(f"theory {text!r}: module {home!r} has no function {name or 'area'!r}")
        return cls(text, values)

    def _called(self, quantity: str, function: Callable[..., Any], *told: Any) -> Array:
        *values, rough = told
        shape = np.shape(values[0])
        try:
            parameters = inspect.signature(function).parameters
            inputs = {name: getattr(rough, name) for name in _TOLD if name in parameters}
            result = np.asarray(function(*values, **inputs))
            if np.iscomplexobj(result):
                raise TypeError("complex numbers")
            result = result.astype(float)
        except Exception as error:  # whatever it raises is its answer
            raise UsageError(
                f"theory {self.label!r}: {quantity} raised {type(error).__name__}: {error}; it is given an "
                f"array, pressures [Pa] for an area, and by name what it lists of {', '.join(_TOLD)}"
            ) from None
        if result.shape != shape:
            raise UsageError(f"theory {self.label!r}: {quantity} of shape {result.shape}: must have {shape}")
        if quantity == "area" and np.any((result < 0) | (result > 1)):
            worst = result.ravel()[np.nanargmax(abs(result - 0.5))]
            raise UsageError(
                f"theory {self.label!r}: area = {worst:.4g}: must lie in [0, 1], or be NaN where it says "
                "nothing; pressures come as an array in Pa, E* by an argument contact_modulus"
            )
        return result

    def area(self, pressure: Array, rough: Rough) -> Array:
        """Return A/A0."""
        raise NotImplementedError  # each has a function of its own


def _module(name: str) -> Any:
    """Import a module that is installed or lies in the folder of the command; None where there is none."""
    with with_own_folder():
        try:
            if not name.replace(".", "_").isidentifier() or importlib.util.find_spec(name) is None:
                return None
            return importlib.import_module(name)
        except ModuleNotFoundError:
            return None
        except Exception as error:
            raise UsageError(
                f"theory {name!r}: cannot be imported: {type(error).__name__}: {error}"
            ) from None
