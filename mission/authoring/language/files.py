"""Files of places that a mission names: read where its author works, and nowhere else.

What does not live here: the formats (mission.authoring.importing.places).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from mission.model import Place

Files = Callable[[str], Sequence[Place]]  # by the path as it is written; raises PlacesError


class PlacesError(Exception):
    """What is wrong, with file and line, and what instead."""

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message, self.hint = message, hint


def no_files(path: str) -> Sequence[Place]:
    """Of a text that came from elsewhere, as by ``@AW``: nobody knows where its files are."""
    message = f"{path}: files of places are read where the mission is a file"
    raise PlacesError(message, "write its places: auvmission convert MISSION --to lines does")
