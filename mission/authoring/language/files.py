"""Files of places that a mission names. They are read on the author's computer only.

What does not live here: the formats (mission.authoring.importing.places).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mission.model import Place

Files = Callable[[str], Sequence[Place]]  # takes the path as written; raises PlacesError


class PlacesError(Exception):
    """A file of places cannot be used: the message has file and line, the hint what to do."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message, self.hint = message, hint


def no_files(path: str) -> Sequence[Place]:
    """Refuse any file. For a text without a folder, such as one sent by ``@AW``."""
    message = f"{path}: files of places are read where the mission is a file"
    raise PlacesError(message, "write its places: auvmission convert MISSION --to lines does")
