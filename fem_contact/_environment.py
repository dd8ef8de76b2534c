"""What the libraries below read from the environment, put right before they are imported.

Schedulers and containers leave things there that libraries stop at with a traceback: ``OMP_NUM_THREADS=2,1``
or empty, a home and a package folder that cannot be written to.
"""

import os
import stat
import tempfile
from pathlib import Path

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def settle() -> None:
    """Put right numbers of threads and the folder of compiled passes; leave alone what is right."""
    for name in _THREADS:
        _settle_threads(name)
    _settle_cache()


def _settle_threads(name: str) -> None:
    """Keep the number for the outermost level, as OpenMP reads a list; drop what is no number.

    >>> os.environ["NUMBA_NUM_THREADS"] = "2,1"
    >>> _settle_threads("NUMBA_NUM_THREADS")
    >>> os.environ.pop("NUMBA_NUM_THREADS")
    '2'
    """
    value = os.environ.get(name)
    if value is None:
        return
    first = value.split(",")[0].strip()
    if first.isascii() and first.isdigit() and int(first) > 0:
        os.environ[name] = first
    else:
        del os.environ[name]


def _settle_cache() -> None:
    """Name a folder for compiled passes where numba would find none: it then refuses to define them."""
    value = os.environ.get("NUMBA_CACHE_DIR")
    if value is not None and _writable(Path(value)):
        return
    os.environ.pop("NUMBA_CACHE_DIR", None)
    packages = [Path(__file__).parents[1] / name / "__pycache__" for name in ("fem_contact", "persson")]
    cache = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    if all(_writable(folder) for folder in packages) or _writable(cache / "numba"):
        return
    private = _private_folder()
    if private is not None:
        os.environ["NUMBA_CACHE_DIR"] = str(private)


def _writable(folder: Path) -> bool:
    """Whether a folder can be written to, or made."""
    for place in (folder, *folder.parents):
        if place.exists():
            return place.is_dir() and os.access(place, os.W_OK | os.X_OK)
    return False


def _private_folder() -> Path | None:
    """Return a folder for temporary files that nobody else can write to: what is cached there is run."""
    user = os.getuid() if hasattr(os, "getuid") else 0
    try:
        folder = Path(tempfile.gettempdir()) / f"fem-contact-{user}"
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except OSError:
        return None
    if stat.S_ISDIR(status.st_mode) and status.st_uid == user and not status.st_mode & 0o077:
        return folder
    return Path(tempfile.mkdtemp(prefix="fem-contact-"))
