"""Studies read back: tables, sentences and budgets from the dataset, the dataset from the stored solves.

Like the rest of the audit it shares no code with what it judges. What it cannot compute again is listed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from validation.audit.dataset import read_json
from validation.audit.ledger import Ledger
from validation.audit.studies.files import judge_files
from validation.audit.studies.kept import Kept
from validation.audit.values import audit_values

__all__ = ["audit_study", "is_study"]

#: What computes each study again.
JUDGES: Mapping[str, Callable[[Kept], None]] = {}


def is_study(folder: Path) -> bool:
    """Whether a folder holds a study."""
    return (folder / "study.json").exists()


def _unknown(kept: Kept) -> str:
    """Say what makes a study another than the one that is computed again; nothing where it is that one."""
    if kept.options.get("scene"):
        return "on a scene: those of its own surfaces are computed again"
    others = set(kept.options.get("methods", ())) - {"bem", "fem"}
    return f"with {', '.join(sorted(others))}: those of bem and fem are computed again" if others else ""


def audit_study(folder: Path) -> Ledger:
    """Compute again what a study printed, and list what was not.

    Parameters
    ----------
    folder : Path
        Results of a study.

    Raises
    ------
    OSError, ValueError, LookupError
        For a folder that holds no finished study of this version.
    """
    if any(isinstance(one, dict) for one in read_json(folder / "summary.json").get("findings", ())):
        return audit_values(folder)
    ledger = Ledger()
    kept = Kept(folder, ledger)
    judge = JUDGES.get(kept.name)
    if judge is None:
        known = ", ".join(sorted(JUDGES))
        ledger.unread.append(
            f"the numbers of the study {kept.name}: those are computed again of {known or 'none'}"
        )
    elif unknown := _unknown(kept):
        judge = None
        ledger.unread.append(f"the numbers of the study {kept.name} {unknown}")
    else:
        judge(kept)
    judge_files(kept)
    if not kept.recipes:
        ledger.unread.append("data.nc against the solves: study.json names no store that holds any")
    for name in kept.data:
        if judge is not None and name not in kept.judged and kept.data[name].dtype.kind == "f":
            ledger.unread.append(f"data.nc: {name}")
    ledger.unread.extend(f"sentence: {sentence}" for sentence in kept.unsaid)
    return ledger
