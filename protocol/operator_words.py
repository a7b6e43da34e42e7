"""The operator's commands that the Pi itself answers (document 000, chapter 1.1), one row each.

    WORDS[StartMission].frame(tolerances)      @AA$
    with WORDS.registered(row): ...            one more, until the block ends

Codecs, acknowledgements, the protocol reference, the names of refusals and the topside programs are
made from these rows.

What does not live here: the frames (``protocol.topside_frames``), relayed commands, X and W
(``protocol.topside``), the effect of a command (``mission.engine.orders``).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from protocol import topside_frames as tables
from protocol.fields import FrameType, Values
from protocol.messages import (
    ClearMission,
    DataQuery,
    MissionLine,
    NodeQuery,
    NodeSwitch,
    SetOutput,
    SetSafety,
    SetTime,
    StartMission,
    StateQuery,
    StoreQuery,
)
from protocol.tables import Table
from protocol.tolerances import Tolerances


def _bare(message: Any) -> Values:
    return {}


@dataclass(frozen=True, slots=True)
class OperatorWord:
    """One command. ``code``: its two letters in the frame's lead and in the acknowledgement.
    ``letter``: the result letter for done; "" if a report is the answer. ``frame`` returns the
    frame type under given tolerances. ``read`` turns a frame's values into a message, ``write`` a
    message into values. ``examples``: good frames."""

    code: str
    message: type
    frame: Callable[[Tolerances], FrameType]
    read: Callable[[Values], Any]
    write: Callable[[Any], Values] = _bare
    letter: str = ""
    examples: tuple[bytes, ...] = ()

    @property
    def name(self) -> str:
        """The name of its frame type."""
        return f"auv.{self.code}"


def _safety(values: Values) -> SetSafety:
    minutes = values["minutes"]
    return SetSafety(
        radius=values["radius_m"],
        time=None if minutes is None else minutes * 60.0,
        depth=values["depth_m"],
        voltage=values["low_voltage_v"],
    )


def _safety_values(message: SetSafety) -> Values:
    minutes = None if message.time is None else round(message.time / 60.0, 6)
    return {
        "radius_m": message.radius,
        "minutes": minutes,
        "depth_m": message.depth,
        "low_voltage_v": message.voltage,
    }


def _fault(row: OperatorWord, others: Any) -> str:
    taken = {other.code for other in others} | _RELAYED_CODES
    if row.code in taken:
        return f"{row.code} is taken"
    if row.letter and row.letter in "N":
        return f"{row.code}: N says no"
    return ""


_RELAYED_CODES = {"RS", "RI", "MT", "MD", "MM", "MR", "MS", "MP", "ZA", "SD", "VS", "AR"}

WORDS: Table[type, OperatorWord] = Table(
    lambda row: row.message,
    (
        OperatorWord(
            "NS",
            NodeSwitch,
            lambda tolerances: tables.NS,
            lambda v: NodeSwitch(v["switches"]),
            lambda m: {"switches": m.switches},
            "S",
            (b"@NSCOOCCC$",),
        ),
        OperatorWord(
            "NI",
            NodeQuery,
            lambda tolerances: tables.NI,
            lambda v: NodeQuery(),
            examples=(b"@NI$",),
        ),
        OperatorWord(
            "AA",
            StartMission,
            lambda tolerances: tables.AA,
            lambda v: StartMission(),
            letter="A",
            examples=(b"@AA$",),
        ),
        OperatorWord(
            "AC",
            ClearMission,
            lambda tolerances: tables.AC,
            lambda v: ClearMission(),
            letter="C",
            examples=(b"@AC$",),
        ),
        OperatorWord(
            "AQ",
            StoreQuery,
            lambda tolerances: tables.AQ,
            lambda v: StoreQuery(),
            examples=(b"@AQ$",),
        ),
        OperatorWord(
            "AE",
            StateQuery,
            lambda tolerances: tables.AE,
            lambda v: StateQuery(),
            examples=(b"@AE$",),
        ),
        OperatorWord(
            "AW",
            MissionLine,
            tables.MissionLineFrame,
            lambda v: MissionLine(v["total"], v["current"], v["payload"]),
            lambda m: {"total": m.total, "current": m.current, "payload": m.payload},
            "W",
            (b"@AW\x01\x00\x01\x00ZAF5$", b"@AW0802ZAF6$"),
        ),
        OperatorWord(
            "AO",
            SetOutput,
            lambda tolerances: tables.OutputFrame(),
            lambda v: SetOutput(v["name"], v["value"]),
            lambda m: {"name": m.name, "value": m.value},
            "O",
            (b"@AO,lamp,40,$",),
        ),
        OperatorWord(
            "ST",
            SetTime,
            tables.TimeFrame,
            lambda v: SetTime(v["time"]),
            lambda m: {"time": m.time},
            "T",
            (b"@ST,2025/01/11 16:56:06,$",),
        ),
        OperatorWord(
            "SP",
            SetSafety,
            lambda tolerances: tables.SafetyFrame(),
            _safety,
            _safety_values,
            "P",
            (b"@SP,1000,5,200,10,$",),
        ),
        OperatorWord(
            "DU",
            DataQuery,
            lambda tolerances: tables.DU,
            lambda v: DataQuery(),
            examples=(b"@DU$",),
        ),
    ),
    _fault,
)
