"""Surfaces, contacts and studies in a few lines: ``import fem_contact as fc``.

The names come from `validation`, which knows theory and solvers both, when one of them is first asked for;
nothing else in this package knows of it.
"""

from importlib import import_module

_NAMES = ("measured", "press", "reference", "self_affine", "study", "table", "theory")
__all__ = ["main", *_NAMES]  # noqa: PLE0604


def __getattr__(name: str) -> object:
    if name not in _NAMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(_ours("notebook"), name)


def main() -> None:
    """Run the command ``fem-contact``."""
    _ours("cli").main()


def _ours(part: str) -> object:
    """Import a part of `validation`; another package of that name is refused with the remedy."""
    package = import_module("validation")
    if not hasattr(package, "belongs_to_fem_contact"):
        raise ImportError(
            f"another package called validation lies in the way, {package.__file__}: "
            "run pip uninstall validation, then pip install --force-reinstall --no-deps fem-contact"
        )
    return import_module(f"validation.{part}")
