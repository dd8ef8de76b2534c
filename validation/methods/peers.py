"""Whether other contact codes are installed, and in which version."""

from __future__ import annotations

import importlib.util
from importlib import metadata

from validation.methods.base import Settings

__all__ = ["installed", "missing"]


def missing(package: str) -> str | None:
    """Return what to install if a package of the extra `peers` is not there; None if it is."""
    if importlib.util.find_spec(package) is not None:
        return None
    return f"{package} is not installed; install it with: pip install 'fem-contact[peers]'"


def installed(package: str) -> Settings:
    """Return the version of a package as a setting, so that another version is solved with anew."""
    try:
        return (("version", metadata.version(package)),)
    except metadata.PackageNotFoundError:
        return ()
