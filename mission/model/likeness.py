"""The known word that a misspelt one most likely means."""

from __future__ import annotations

import difflib
import itertools
from collections.abc import Iterable, Sequence

from mission.model.extent import NAME

_COMPARED = 500  # names, at most, that a misspelt one is compared with


def nearest(word: str, known: Iterable[str], likeness: float = 0.6) -> str:
    """Return the known name that ``word`` most likely means, or "" if none is similar enough."""
    if len(word) > 2 * NAME.most:
        return ""
    names = {name.lower(): name for name in itertools.islice(known, _COMPARED)}
    found = difflib.get_close_matches(word.lower(), names, n=1, cutoff=likeness)
    return names[found[0]] if found else ""


def suggestion(word: str, known: Sequence[str], what: str) -> str:
    """A hint: the nearest known name; if there is none, the first 30 known names."""
    close = nearest(word, known)
    if close:
        return f"did you mean {close}?"
    shown = ", ".join(known[:30])
    return f"{what}: {shown}" if known else ""
