"""The state report ``@AE,1,...$``: at most 64 bytes, with the ages of report and fix (R4).

    @AE,1,AU,Y,1,423,38,-120,45,7,860,31,1.9,0,F50%H90S3,survey/row,$

    version state commander | ages of the last report and fix, s | 95 % radius, m
    estimate less last fix: north, east, m | left to the limits of depth, radius (m), time (min),
    voltage (V) | alarms, a mask | setpoint in force | leg

An unknown value is empty; a value beyond its range is sent as the end of the range. Setpoint and
leg, the last items, take the space that is left; ``~`` replaces what does not fit.

What does not live here: what the bits of the mask mean (``mission.model.alarms``).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from protocol.codec import CannotEncode
from protocol.fields import FaultKind, Values, required
from protocol.messages import Order, Setpoint, StateReport
from protocol.status_frame import Item
from protocol.text import Refused, TextFrame, format_decimal, parse_decimal

VERSION = "1"
MOST = 64  # bytes of the frame
CUT = "~"
STATES: Mapping[str, str] = MappingProxyType(
    {
        "IE": "idle/empty",
        "IR": "idle/ready",
        "AU": "autonomous",
        "MD": "manual/driving",
        "MW": "manual/waiting",
        "ES": "emergency/stopped",
        "EU": "emergency/surfacing",
        "EF": "emergency/surfaced",
    }
)
COMMANDERS: Mapping[str, str] = MappingProxyType(
    {"-": "nobody", "Y": "asker", "N": "network", "M": "modem"}
)
NUMBERS = (
    Item("report_age", 0, 9999, 0),
    Item("fix_age", 0, 9999, 0),
    Item("uncertainty_m", 0, 9999, 0),
    Item("north_m", -9999, 9999, 0),
    Item("east_m", -9999, 9999, 0),
    Item("to_depth_m", -99, 999, 0),
    Item("to_radius_m", -999, 9999, 0),
    Item("to_time", -99, 999, 0),
    Item("to_voltage_v", -9.9, 99.9, 1),
)
NAMES = ("state", "commander", *(item.name for item in NUMBERS), "alarms", "setpoint", "leg")
_MASK = re.compile(r"[0-9A-F]{1,4}")
_TEXT = re.compile(r"[ -#%-+\--?A-~]*")
_STATE_LETTERS = {state: letters for letters, state in STATES.items()}
_COMMANDER_LETTERS = {who: letter for letter, who in COMMANDERS.items()}


class StateFrame(TextFrame):
    def __init__(self) -> None:
        super().__init__("auv.AES", "000 table 1.1.2, a reserved code (R4)", "@AE", limit=MOST)

    def parse(self, body: str) -> Values:
        before, *parts, behind = body.split(",") if "," in body else ("?", "")
        if before or behind or len(parts) != 1 + len(NAMES):
            raise Refused(FaultKind.FIELD_COUNT)
        version, state, commander, *numbers = parts[: 3 + len(NUMBERS)]
        mask, setpoint, leg = parts[3 + len(NUMBERS) :]
        if version != VERSION or state not in STATES or commander not in COMMANDERS:
            raise Refused(FaultKind.BAD_ENUM)
        if not _MASK.fullmatch(mask):
            raise Refused(FaultKind.NON_NUMERIC)
        known = {item.name: _number(item, t) for item, t in zip(NUMBERS, numbers, strict=True)}
        names = {"state": STATES[state], "commander": COMMANDERS[commander]}
        return {**names, **known, "alarms": int(mask, 16), "setpoint": setpoint, "leg": leg}

    def format(self, values: Mapping[str, Any]) -> str:
        given = {name: required(values, name, self.name) for name in NAMES}
        try:
            state, who = _STATE_LETTERS[given["state"]], _COMMANDER_LETTERS[given["commander"]]
        except KeyError as error:
            raise CannotEncode(f"{self.name}: no state and no commander is {error}") from None
        for name in ("setpoint", "leg"):
            if not isinstance(given[name], str) or not _TEXT.fullmatch(given[name]):
                raise CannotEncode(f"{self.name}: {name} is text without , @ and $")
        numbers = [_written(item, given[item.name]) for item in NUMBERS]
        texts = [VERSION, state, who, *numbers, f"{given['alarms']:X}"]
        return "," + ",".join([*texts, given["setpoint"], given["leg"]]) + ","


def _number(item: Item, text: str) -> float | None:
    if not text:
        return None
    value = parse_decimal(text)
    if not item.low <= value <= item.high:
        raise Refused(FaultKind.OUT_OF_RANGE)
    return value


def _written(item: Item, value: float | None) -> str:
    """Return the value as text, clamped to its range; "" if it is not known."""
    if value is None or math.isnan(value):
        return ""
    return format_decimal(item.name, min(max(value, item.low), item.high), item.places)


def fitted(report: StateReport, encoded: int) -> StateReport:
    """Return ``report``, whose frame would have ``encoded`` bytes, with setpoint and leg cut so
    that it has ``MOST``. The setpoint stays whole or becomes ``~``. The leg loses its groups first,
    then the end of its own name."""
    spare = MOST - encoded + len(report.setpoint) + len(report.leg)
    setpoint = report.setpoint if len(report.setpoint) <= spare else CUT[:spare]
    room = spare - len(setpoint)
    names = (report.leg, report.leg.rpartition("/")[2])
    leg = next((name for name in names if len(name) <= room), "")
    if not leg and report.leg and room:
        leg = names[1][: room - 1] + CUT
    return StateReport(**{**values_of(report), "setpoint": setpoint, "leg": leg})


def values_of(report: StateReport) -> Values:
    return {name: getattr(report, name) for name in NAMES}


# --- the setpoint in force ---

_SHARES = (("surge", "F", "B"), ("turn", "R", "L"), ("heave", "D", "U"))
_ANGLES = (("heading", "H"), ("pitch", "P"), ("roll", "O"))
_DEPTHS = (("depth", "S"), ("altitude", "E"))
_WORDS: Mapping[str, str] = MappingProxyType(
    {
        "F": "ahead {} %", "B": "astern {} %", "R": "to starboard {} %", "L": "to port {} %",
        "D": "down {} %", "U": "up {} %", "H": "heading {} deg", "P": "pitch {} deg",
        "O": "roll {} deg", "S": "depth {} m", "E": "altitude {} m",
    }
)  # fmt: skip
_ALONE: Mapping[str, str] = MappingProxyType(
    {"X": "everything stopped", "W": "emergency surfacing", "M": "the stick", CUT: "more than fits"}
)
STICK = "M"


def setpoint_text(command: Setpoint | Order | None) -> str:
    """Return a command in the document's letters, shares in percent: ``F50%H90S3``; "" for None."""
    if command is None:
        return ""
    if isinstance(command, Order):
        return "X" if command is Order.STOP else "W"
    parts = []
    for name, ahead, back in _SHARES:
        share = round(100 * (getattr(command, name) or 0.0))
        if share:
            parts.append(f"{ahead if share > 0 else back}{abs(share)}%")
    for name, letter in (*_ANGLES, *_DEPTHS):
        value = getattr(command, name)
        if value is not None:
            shown = math.degrees(value) if (name, letter) in _ANGLES else value
            parts.append(f"{letter}{round(shown, 1):g}")
    return "".join(parts) or "X"


def setpoint_words(text: str) -> str:
    """Return such a text in words for the operator; any other text unchanged."""
    if text in _ALONE:
        return _ALONE[text]
    parts = re.findall(r"([A-Z])(-?[0-9.]+)%?", text)
    if not parts or any(letter not in _WORDS for letter, _ in parts):
        return text
    return ", ".join(_WORDS[letter].format(number) for letter, number in parts)
