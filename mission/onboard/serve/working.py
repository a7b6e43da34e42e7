"""The last configuration that worked, kept beside the store: an ascent needs it if the present one
cannot be read.

    <folder>/working                 like the store's files: a checksum, and JSON
    ~/.local/state/auvmission/working-<8 hex of the configuration file's path>
                                     the same, if only that file says which folder

A configuration has worked once bytes of the vehicle were received with it; the very first one is
kept without that. The file also has the vehicle's commands for an ascent, for a program that cannot
load the codec (lifeboat). What does not live here: when it is used (provision).
"""

from __future__ import annotations

import contextlib
import json
from dataclasses import dataclass
from pathlib import Path

from mission.model.plain import from_plain, to_plain
from mission.model.vehicle import Vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.kept import Homes, read_summed, write_summed
from protocol.messages import UPWARD, Order
from protocol.vehicles import codec, line_rate


@dataclass(frozen=True, slots=True)
class Working:
    configuration: Configuration
    vehicle: Vehicle


def find(homes: Homes) -> Working | None:
    """Return the first of the files that is whole, None if none is."""
    return next((found for path in homes.paths() if (found := _read(path)) is not None), None)


def keep(working: Working, homes: Homes) -> None:
    """Write it where it is not yet. Raises OSError."""
    text = json.dumps(_plain(working), sort_keys=True)
    for path in homes.places(working.configuration.folder):
        if _text(path) != text:
            write_summed(path, text)


def _plain(working: Working) -> dict[str, object]:
    c, v = working.configuration, working.vehicle
    made = codec(*v.speaks)
    made.take_outputs(v.safe_levels)
    ways: dict[str, list[str]] = {}
    for name, command in (("stop", Order.STOP), ("surface", Order.SURFACE), ("up", UPWARD)):
        with contextlib.suppress(ValueError):  # the robot on land has no command for up
            ways[name] = [frame.hex() for frame in made.encode(command)]
    return {
        "configuration": to_plain(c),
        "vehicle": to_plain(v),
        "ways": ways,
        "period": getattr(made, "period", None),
        "baud": line_rate(v.codec, v.wire),
    }


def _text(path: Path) -> str | None:
    try:
        return read_summed(path)
    except (OSError, ValueError):
        return None


def _read(path: Path) -> Working | None:
    """Read a file; None if it is not whole, or of another version."""
    text = _text(path)
    if text is None:
        return None
    try:
        plain = json.loads(text)
        return Working(
            from_plain(Configuration, plain["configuration"]),
            from_plain(Vehicle, plain["vehicle"]),
        )
    except (ValueError, TypeError, KeyError):
        return None
