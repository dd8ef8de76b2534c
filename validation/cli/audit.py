"""The command `fem-contact audit`."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

from validation.cli.options import FolderArgument, JsonOption, option, print_json, show
from validation.errors import RunFailed, UsageError


def audit(
    folder: FolderArgument,
    list_all: Annotated[bool, option("--list", help="Name the numbers that agree, too.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Compute every number of a result again from its fields, by other code.

    Tables, JSON, sentences, the page and the data of its figures are compared with what the fields say by
    definition; what is not computed again is listed. Exits with 1 where a number disagrees.
    """
    from validation.audit import audit as read
    from validation.cli.progress import under_way

    try:
        with under_way("computing the numbers again", quiet=as_json):
            ledger = read(folder)
    except (OSError, ValueError, LookupError) as error:
        absent = Path(error.filename).name if isinstance(error, FileNotFoundError) else error
        why = f"no {absent} in it" if isinstance(error, (FileNotFoundError, KeyError)) else error
        raise UsageError(f"{folder}: cannot be audited: {why}; run it again, or name a result") from None
    if as_json:
        print_json({"entries": [asdict(entry) for entry in ledger.entries], "unread": ledger.unread})
    else:
        for entry in ledger.entries if list_all else ledger.wrong:
            show(str(entry))
        for line in dict.fromkeys(ledger.unread):
            show(f"not judged: {line}")
        agreeing = Counter(entry.place for entry in ledger.entries if entry.agrees)
        files = {place: n for place, n in agreeing.items() if re.search(r"\.(json|csv|nc|html)\b", place)}
        rest = sum(agreeing.values()) - sum(files.values())
        for place, count in {**files, **({"fields of the solves": rest} if rest else {})}.items():
            show(f"{place}: {count} agree")
    if ledger.wrong:
        raise RunFailed(
            f"{len(ledger.wrong)} of {len(ledger.entries)} numbers disagree with the stored fields"
        )
