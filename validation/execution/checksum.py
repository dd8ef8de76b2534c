"""A seal at the end of a stored file: what it is a result of, how it was made, and a SHA-256 over all of it.

A sealed file is the bytes of a netCDF file, one line of JSON, and a last line ``sha256`` with the digest of
every byte before it. netCDF readers know where their data end and do not see the two lines. Nothing is parsed
before the digest is found right: what a flipped bit, a lost block or a cut end would make of it is never
asked, and reading takes the time of one pass over the bytes.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

_WORD = b"sha256 "
_FOOT = len(_WORD) + 64 + 1


class Damaged(Exception):
    """Bytes that are not those that were written; says how it shows."""


@dataclass(frozen=True, kw_only=True)
class Sealed:
    """The netCDF file in a sealed file that is intact, `Solve.recipe_text`, and how it was made, as JSON."""

    content: memoryview
    recipe: str
    made: Mapping[str, Any]


def seal(content: bytes | memoryview, *, recipe: str, made: Mapping[str, Any]) -> bytes:
    """Return the two lines that go behind the content."""
    line = b"\n" + json.dumps({"recipe": recipe, "made": dict(made)}).encode() + b"\n"
    digest = hashlib.sha256(content)
    digest.update(line)
    return line + _WORD + digest.hexdigest().encode() + b"\n"


def unseal(data: bytes) -> Sealed:
    """Return what a sealed file holds; `Damaged` where any byte of it is not the one that was written."""
    view = memoryview(data)
    body, foot = view[:-_FOOT], bytes(view[-_FOOT:])
    if len(data) <= _FOOT or not foot.startswith(_WORD) or not foot.endswith(b"\n"):
        raise Damaged("no digest at its end: it was cut off, or written by an earlier version")
    if foot != _WORD + hashlib.sha256(body).hexdigest().encode() + b"\n":
        raise Damaged("its bytes are not those that were written (SHA-256)")
    start = data.rfind(b"\n", 0, len(body) - 1)
    return Sealed(content=body[:start], **json.loads(bytes(body[start + 1 :])))
