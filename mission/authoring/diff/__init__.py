"""The differences between two missions for the vehicle, not between their texts.

difference = compare(prepared_before, prepared_after)     # .same, .changes, .figures
"""

from mission.authoring.diff.changes import Change, Kind
from mission.authoring.diff.difference import Difference, Figure, compare

__all__ = ["Change", "Difference", "Figure", "Kind", "compare"]
