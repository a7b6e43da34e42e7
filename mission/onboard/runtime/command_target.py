"""What the operator's side and the runtime ask of each other: types, and how an answer is written.

What does not live here: the rules between them (topside), the vehicle's behaviour (engine).
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
    """What the operator's commands act upon; the runtime is one."""

    @property
    def state(self) -> str:
        """The active state's path."""
        ...

    @property
    def digest(self) -> str:
        """Of the stored mission, hex; "" if there is none."""
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
        """What the vehicle was told it shall be, None where nothing was."""
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
        """Something that the journal should have."""
        ...

    def meaning_of_no(self, frame: bytes) -> str:
        """Why the vehicle has probably refused this frame, "" if nothing is known."""
        ...

    def relay(self, frame: bytes, reason: str, manual: bool) -> str:
        """Why it will not leave, "" if it will."""
        ...

    def accept(self, lines: tuple[str, ...], now: float) -> None:
        """Compile, check, store and load a mission; raises MissionRefused or StoreError."""
        ...

    def status(self, now: float) -> Status: ...

    def state_report(self, asker: Peer, now: float) -> StateReport: ...

    def set_clock(self, time: str, now: float) -> None: ...


_CARRIED = str.maketrans({",": ";", "@": None, "$": None})


def one_line(text: str) -> str:
    """ASCII without comma, ``@`` and ``$``, at most 200 characters (R4); still to be read."""
    text = text.translate(_CARRIED)
    kept = (c if " " <= c <= "~" else " " for c in text)
    return " ".join("".join(kept).split())[:REFUSAL_CHARACTERS]


def name_of(command: Command) -> str:
    """As a refusal has it."""
    if isinstance(command, Relay):
        return "relay"
    return "manual" if isinstance(command, Manual) else WORDS[type(command)].code


def acknowledge(command: Command, accepted: bool, now: float) -> Ack | None:
    """R2; None for what only the STM32 may answer."""
    if isinstance(command, Relay | Manual):
        return None
    return answer(name_of(command), accepted, now)
