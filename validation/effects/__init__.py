"""Effects beyond linear elastic contact of a half-space: one file each, found by name or entry point."""

from collections.abc import Mapping
from functools import cache

from validation.effects.base import Effect
from validation.registry import found_in

__all__ = ["Effect", "effect_kinds"]


@cache
def effect_kinds() -> Mapping[str, type[Effect]]:
    """Return all effects by the word that lists them: those of this package, then those of other packages.

    Another package adds one by an entry point of the group ``fem_contact.effects``.
    """
    return {kind.kind_name(): kind for kind in found_in(__name__, Effect, group="fem_contact.effects")}
