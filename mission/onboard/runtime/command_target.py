"""The interface between operator server and runtime: types, and how an answer is written.

What does not live here: the rules between them (operator_server), the vehicle's behaviour (engine).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from mission.model import Verdict
from protocol.messages import (
    Ack,
    Command,
    Manual,
    Relay,
    StateReport,
    Status,
)
from protocol.operator_words import WORDS
from protocol.topside import Answer as Answer
from protocol.topside import answer

MODEM = "modem"  # the link whose frames travel in envelopes under water

REFUSAL_CHARACTERS = 200


@dataclass(frozen=True, slots=True, order=True)
class Peer:
    link: str
    address: str

    def __str__(self) -> str:
        return f"{self.link} {self.address}".rstrip()


class MissionRefused(ValueError):
    """The mission's author must act; the message names the first line and its fault."""


class CommandTarget(Protocol):
    """The object that the operator's commands act upon: the runtime."""

    @property
    def state(self) -> str:
        """The active state's path."""
        ...

    @property
    def digest(self) -> str:
        """The digest of the stored mission, hex; "" if there is none."""
        ...

    @property
    def under_way(self) -> str:
        """What an end of the program would interrupt, "" if nothing."""
        ...

    @property
    def doubted_at(self) -> float:
        """When a report last contradicted a stop, -inf: never."""
        ...

    def output(self, name: str) -> float | None:
        """The value that was commanded for this output; None if none was."""
        ...

    def decide(self, command: Command, now: float) -> Verdict: ...

    def switch_auto(self, is_open: bool, now: float) -> None: ...

    def hear_stick(self, now: float) -> None:
        """An M that was refused: a stick is held somewhere (R6)."""
        ...

    def cannot_relay(self, frame: bytes) -> str:
        """Why the vehicle has no such M, R or D, "" if it has (R14)."""
        ...

    def notice(self, text: str) -> None:
        """Write a text to the journal."""
        ...

    def meaning_of_no(self, frame: bytes) -> str:
        """Why the vehicle has probably refused this frame, "" if nothing is known."""
        ...

    def relay(self, frame: bytes, reason: str, manual: bool) -> str:
        """Pass the frame on; why it will not leave, "" if it will."""
        ...

    def accept(self, lines: tuple[str, ...], now: float) -> None:
        """Compile, check, store and load a mission; raises MissionRefused or StoreError."""
        ...

    def status(self, now: float) -> Status: ...

    def state_report(self, asker: Peer, now: float) -> StateReport: ...

    def set_clock(self, time: str, now: float) -> None: ...


_CARRIED = str.maketrans({",": ";", "@": None, "$": None})


def one_line(text: str) -> str:
    """Reduce a text to ASCII without comma, ``@`` and ``$``, at most 200 characters (R4)."""
    text = text.translate(_CARRIED)
    kept = (c if " " <= c <= "~" else " " for c in text)
    return " ".join("".join(kept).split())[:REFUSAL_CHARACTERS]


def name_of(command: Command) -> str:
    """The command's name in a refusal."""
    if isinstance(command, Relay):
        return "relay"
    return "manual" if isinstance(command, Manual) else WORDS[type(command)].code


def acknowledge(command: Command, accepted: bool, now: float) -> Ack | None:
    """The acknowledgement of a command (R2); None if only the STM32 may answer it."""
    if isinstance(command, Relay | Manual):
        return None
    return answer(name_of(command), accepted, now)
