"""The journal of a running serve: lines in order, each with its level; repeated ones are counted.

    info     normal operation: states, commands sent to the vehicle with their reason
    warning  somebody should look at it: refusals, lost ports, a fault of a limit
    fault    the program or the vehicle needs help now

A line that repeats within a minute is counted, and the count is written afterwards. Of a ``kind``
that others can multiply (by addresses, by connections), ``OF_A_KIND`` different lines are written
within a minute, and the rest are counted: no flood fills the disk. What does not live here: the
black box, which has everything.
"""

from __future__ import annotations

import json
import os
import traceback
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime

from mission.model import Estimate, Record, Step, Tx
from mission.model.regions import EMERGENCY
from mission.onboard.runtime.records import FAULT as FAULT_RECORD
from mission.onboard.runtime.records import Observer
from mission.onboard.stream.events import HELD, answers_in, reason_of

INFO, WARNING, FAULT = "info", "warning", "fault"
LEVELS = {INFO: 6, WARNING: 4, FAULT: 3}  # syslog's numbers
AGAIN_S = 60.0
OF_A_KIND = 20  # different lines that are written within ``AGAIN_S``
REMEMBERED = 512
DEEPEST, CAUSES = 30, 5  # stack frames that are written of an error; chained errors
_COMMAND = "to the vehicle\0"  # begins the keys of commands to the vehicle


@dataclass(slots=True)
class _Told:
    t: float
    level: str
    text: str
    more: int = 0


class Journal:
    """``now`` is any clock that does not go back."""

    def __init__(self, write: Callable[[str], None], now: Callable[[], float]) -> None:
        self._write, self._now = write, now
        self.told: dict[str, _Told] = {}
        self._unsent = False  # the last command could not leave

    def info(self, text: str, key: str = "", kind: str = "") -> None:
        """``key``: lines with the same key count as repeated; by default the text."""
        self._tell(INFO, text, key, 1, kind)

    def warning(self, text: str, key: str = "", times: int = 1, kind: str = "") -> None:
        self._tell(WARNING, text, key, times, kind)

    def fault(self, text: str) -> None:
        """Write a fault, even a repeated one."""
        self._write(f"{FAULT}: {text.rstrip()}")

    def error(self, text: str, error: BaseException) -> None:
        """Write an error with its stack, without source lines: the SD card with them may hang."""
        self.fault("\n".join([text, *_places_of(error)]))

    def settle(self) -> None:
        """Write the counts whose minute is over; to be called regularly."""
        now = self._now()
        self._end([k for k, told in self.told.items() if now - told.t >= AGAIN_S])

    def _forget(self, prefix: str) -> None:
        self._end([k for k in self.told if k.startswith(prefix)])

    def _end(self, keys: Iterable[str]) -> None:
        for key in keys:
            told = self.told.pop(key)
            if told.more:
                self._write(f"{told.level}: {told.more} more of: {told.text}")

    def _tell(self, level: str, text: str, key: str, times: int, kind: str = "") -> None:
        now, key = self._now(), f"{kind}\0{key or text}" if kind else key or text
        if kind and key not in self.told and self._is_full(kind, now):
            key, text = kind, f"{kind}: beyond {OF_A_KIND} different ones a minute they are counted"
        told = self.told.get(key)
        if told is not None and now - told.t < AGAIN_S:
            told.more += times
            return
        if told is not None or len(self.told) >= REMEMBERED:
            self.settle()
        if len(self.told) < REMEMBERED:
            self.told[key] = _Told(now, level, text, times - 1)
        self._write(f"{level}: {text.rstrip()}")

    def _is_full(self, kind: str, now: float) -> bool:
        recent = (told for key, told in self.told.items() if key.startswith(f"{kind}\0"))
        return sum(now - told.t < AGAIN_S for told in recent) >= OF_A_KIND

    # --- what a runtime does -----------------------------------------------------------------

    def commanded(self, tx: Tx, sent: bool) -> None:
        """Log a command to the vehicle: a stick that is held once a minute, the repeats of the
        command in force not at all."""
        if sent and tx.reason.endswith(HELD) and not self._unsent:
            return
        self._unsent = not sent
        frame = _shown(tx.data)
        manual = "@M" in tx.reason or "@D" in tx.reason
        key = _COMMAND + (tx.reason if manual else f"{frame} {tx.reason}")
        if sent:
            self.info(f"to the vehicle: {frame} - {tx.reason}", key)
        else:
            self.warning(f"NOT SENT, the port is closed: {frame} - {tx.reason}", f"{key} not sent")

    def answered(self, tx: Tx) -> None:
        """Log the refusals in an answer to topside."""
        to = f"{tx.link} {tx.address}".rstrip()
        for word, refused in answers_in(tx.data):
            if refused:
                said = f"refused: @ACK_{word}N$ to {to} - {tx.reason}"
                self.warning(said, kind="refused commands")

    def commands(self, peer: str, loser: str) -> None:
        if loser:
            text = f"{peer} has taken the command over from {loser}"
            self.warning(text, kind="changes of command")
        else:
            self.info(f"{peer} commands", kind="new commanders")

    def step(self, step: Step) -> None:
        if step.entered:  # in another state the same command is not a repetition
            self._forget(_COMMAND)
        for path in step.entered[-1:]:
            because = step.trigger or step.event
            what = "; ".join(step.actions) or _without_words(step)
            self._now_in(path, f"{because}{': ' if what else ''}{what}")

    def estimate(self, estimate: Estimate) -> None:
        """Not logged."""

    def notice(self, text: str) -> None:
        self.warning(text, kind="refused commands")

    def _now_in(self, path: str, because: str) -> None:
        level = WARNING if path.startswith(EMERGENCY) else INFO
        self._write(f"{level}: now {path} - {because}")


def _without_words(step: Step) -> str:
    """The reason of a step that sent no command: which limit acted, or that an ascent goes on."""
    return reason_of(step) if step.trigger in ("limit", "surfaced") else ""


class Several:
    """Forwards to the observers of one runtime, in their order."""

    def __init__(self, *observers: Observer) -> None:
        self._observers = observers

    def step(self, step: Step) -> None:
        for observer in self._observers:
            observer.step(step)

    def estimate(self, estimate: Estimate) -> None:
        for observer in self._observers:
            observer.estimate(estimate)

    def notice(self, text: str) -> None:
        for observer in self._observers:
            observer.notice(text)


class Tally:
    """A sink of records that counts faults by link."""

    def __init__(self) -> None:
        self.faults: Counter[str] = Counter()

    def record(self, record: Record) -> None:
        if record.kind == FAULT_RECORD:
            self.faults[json.loads(record.payload)["link"]] += 1


def _shown(data: bytes) -> str:
    return data.decode("ascii") if data.isascii() else data.hex(" ")


def printed(line: str, wall: float) -> str:
    """The line for output: with a syslog level for the system's journal, else with the time."""
    level, _, text = line.partition(": ")
    if level not in LEVELS:
        level, text = INFO, line
    if "JOURNAL_STREAM" in os.environ:
        return "\n".join(f"<{LEVELS[level]}>{row}" for row in text.split("\n"))
    stamp = datetime.fromtimestamp(wall, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return f"{stamp} {level:7} {text}"


def _places_of(error: BaseException) -> Iterator[str]:
    """The stack of an error, innermost frame last, and its text; then the same of its causes."""
    told: list[BaseException] = []
    one: BaseException | None = error
    while one is not None and not any(one is other for other in told) and len(told) < CAUSES:
        if told:
            yield "caused by:"
        for frame, line in deque(traceback.walk_tb(one.__traceback__), DEEPEST):
            yield f"  {frame.f_code.co_filename}:{line} {frame.f_code.co_name}"
        try:
            yield f"{type(one).__name__}: {one}"
        except Exception:
            yield type(one).__name__
        told.append(one)
        one = one.__cause__ or one.__context__
