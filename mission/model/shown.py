"""Values as people read them in pictures and tables: rounded, with units.

Only plain characters (ASCII, Latin-1), because a picture is shown with the fonts of the machine.
What does not live here: numbers that read back as the same bits (units.number_text).
"""

from __future__ import annotations

import math

from mission.model.texts import Local, Place, Position


def number(value: float) -> str:
    """At most three digits after the point, no trailing zeros."""
    return f"{round(value, 3):.10g}"


def duration(seconds: float) -> str:
    if seconds >= 120 and seconds % 60 == 0:
        return f"{number(seconds / 60)} min"
    return f"{number(seconds)} s"


def clock(seconds: float) -> str:
    """Minutes and seconds since the program began, hours where there are any: 2:07:31.4."""
    minutes, rest = divmod(round(seconds, 1), 60.0)
    hours, minutes = divmod(int(minutes), 60)
    whole = f"{hours}:{minutes:02}" if hours else f"{minutes}"
    return f"{whole}:{rest:04.1f}"


def bearing(radians: float) -> str:
    return f"{round(math.degrees(radians), 1) % 360:03g}\u00b0"


def place(value: Place) -> str:
    match value:
        case Position(latitude, longitude):
            return f"{latitude:.5f}, {longitude:.5f}"
        case Local(north, east):
            ns, ew = "N" if north >= 0 else "S", "E" if east >= 0 else "W"
            return f"{number(abs(north))} m {ns} {number(abs(east))} m {ew}"
        case _:
            return str(value)
