"""The stick of document 000 (table 1.2.2) for vehicles whose documents have no M: it sets efforts.

    @MMF6$ @MMB6$   surge  6/12 of the stick's share, ahead or back; ends a turn
    @MRL3$ @MRR3$   turn   3/5, to port or starboard; ends surge, as the AUV's main thrusters would
    @MMU6$ @MMD6$   heave  6/12, up or down; surge and turn continue
    @MT @MD @MS @MP, and leans by @MR   refused: there is no such thruster, rudder or angle

``stick_surge``, ``stick_turn`` and ``stick_heave`` of the ``wire`` table are the share of the full
effort at the stick's full deflection. A vehicle without such a key has no such axis.

What does not live here: when an operator may take over with the stick, and when it counts as
released (runtime, engine).
"""

from __future__ import annotations

import re
from dataclasses import replace

from protocol.codec import CannotEncode
from protocol.messages import Setpoint
from protocol.vehicles.keys import Key, Wire

_WORD = re.compile(rb"@(MM|MR)([A-Z])(-?0{1,5}|\d{1,5})\$")
LACKS = "no R and no D"
_FULL = {"MM": 12, "MR": 5}
_AXES = {
    "MMF": ("surge", 1),
    "MMB": ("surge", -1),
    "MRR": ("turn", 1),
    "MRL": ("turn", -1),
    "MMD": ("heave", 1),
    "MMU": ("heave", -1),
}
_NONE = {
    "MT": "no single thruster",
    "MD": "no rudder",
    "MS": "no heading that a stick could hold",
    "MP": "no attitude that a stick could hold",
    "MR": "no attitude that a stick could hold",
}


def stick_keys(*axes: str) -> tuple[Key, ...]:
    """Return the stick's keys for a vehicle with these of surge, turn and heave."""
    what = "share of the full effort at the stick's end"
    return tuple(Key(f"stick_{axis}", 1, 0.05, 1, f"{axis}: {what}", whole=False) for axis in axes)


def steered(held: Setpoint, word: bytes, wire: Wire) -> Setpoint:
    """Return the setpoint after the M command ``word``, where ``held`` is the one before. Raises
    CannotEncode."""
    kind = word[1:3].decode("ascii", "replace")
    found = _WORD.fullmatch(word)
    if found is None and not kind.startswith("M"):
        raise CannotEncode(f"this vehicle has {LACKS}")
    axis, sign = _AXES.get(f"{kind}{found[2].decode()}" if found else "", ("", 0))
    if found is None or not axis:
        raise CannotEncode(f"this vehicle has no @{kind}: {_NONE.get(kind, 'no such word')}")
    share = wire.get(f"stick_{axis}")
    if share is None:
        raise CannotEncode(f"this vehicle has no @{kind}{found[2].decode()}: no {axis}")
    value = sign * share * int(found[3]) / _FULL[kind]
    if axis == "heave":
        return replace(held, heave=value)
    return replace(held, **({"surge": 0.0, "turn": 0.0} | {axis: value}))
