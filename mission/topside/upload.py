"""An operator's requests to a Pi: upload, start, clear, status. Sans-IO.

A conversation is a script (a generator) that yields one ``Ask`` at a time and gets its answer.
``Conversation`` sends it, retries it (R1: 1 s, 3 tries; never an @AC: a second one, seconds later,
would be a second command), and drops all other frames.

    upload:  @AQ  there already? --> line 1 --> @AQ: which are missing? --> those, one by one
             --> @AQ: none missing, and the digest is ours

An acknowledgement does not say which line it belongs to (R3). So the Pi's own list of missing lines
decides, not the number of answers: an interrupted upload continues where it stopped.

    OperatorError      (the operator must act)
    +-- NoAnswer       after all tries; nothing is assumed of what it did
    +-- Refused        by the Pi, with its reason

What does not live here: X and W (orders), sockets and clocks (console), the Pi's side (topside),
frames (protocol).
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass

from protocol.batch import NOT_IDLE
from protocol.messages import (
    Ack,
    ClearMission,
    Command,
    DataQuery,
    FrameFault,
    MissionLine,
    StartMission,
    Status,
    StoreQuery,
    StoreReport,
)
from protocol.topside import Answer, ConsoleCodec, encode

ANSWER_S = 1.0
TRIES = 3
ROUNDS = 4  # successive rounds without progress: then the link counts as unusable
WHAT_LISTENS = (
    "is this the operator's port of a vehicle running auvmission serve, not its monitor's?"
)
WHO_HEARS = "is the vehicle's modem in the water, within reach, and its serve's links.modem?"


class OperatorError(Exception):
    pass


class NoAnswer(OperatorError):
    pass


class Refused(OperatorError):
    pass


@dataclass(frozen=True, slots=True)
class Ask:
    """One request; ``fits`` recognises its answer among everything received."""

    what: str
    command: Command
    fits: Callable[[Answer], bool]
    tries: int = TRIES
    by_clock: bool = False  # each try lasts ANSWER_S, however slow the link
    waits: int = 1  # factor on the time of a try, by radio


Script = Generator[Ask, Answer | None, str]
"""Gets None where no answer came; returns what is told to the operator."""


class Scripted:
    """A running script. At its end either ``result`` or ``failure`` is set."""

    def __init__(self, script: Script) -> None:
        self._script = script
        self._ask: Ask | None = None
        self.result: str | None = None
        self.failure: OperatorError | None = None

    @property
    def over(self) -> bool:
        return self.result is not None or self.failure is not None

    def _next(self, answer: Answer | None) -> Ask | None:
        """Return the script's request after this answer; None when it is over."""
        try:
            self._ask = next(self._script) if self._ask is None else self._script.send(answer)
        except StopIteration as end:
            self.result = end.value
            return None
        except OperatorError as error:
            self.failure = error
            return None
        return self._ask


class Conversation(Scripted):
    """A script by radio: each request is repeated until it is answered (R1). ``patience``: s per
    try."""

    def __init__(self, script: Script, patience: Callable[[], float] = lambda: ANSWER_S) -> None:
        super().__init__(script)
        self._patience = patience
        self._codec = ConsoleCodec()
        self._tries, self._due = 0, 0.0

    def begin(self, now: float) -> list[bytes]:
        return self._go(None, now)

    def next_timer(self) -> float | None:
        return None if self.over else self._due

    def handle_timer(self, now: float) -> list[bytes]:
        """Repeat the request when its time is over, or continue the script without an answer."""
        if self.over or self._ask is None or now < self._due:
            return []
        if self._tries < self._ask.tries:
            return self._send(now)
        return self._go(None, now)

    def receive(self, data: bytes, now: float) -> list[bytes]:
        out: list[bytes] = []
        for answer in self._codec.receive(data, now):
            waiting = self._ask if not self.over else None
            if waiting is not None and not isinstance(answer, FrameFault) and waiting.fits(answer):
                out += self._go(answer, now)
        return out

    def _go(self, answer: Answer | None, now: float) -> list[bytes]:
        if self._next(answer) is None:
            return []
        self._tries = 0
        return self._send(now)

    def _send(self, now: float) -> list[bytes]:
        assert self._ask is not None
        wait = ANSWER_S if self._ask.by_clock else self._patience()
        self._tries, self._due = self._tries + 1, now + wait * self._ask.waits
        return [encode(self._ask.command)]


# --- scripts -----------------------------------------------------------------------------------


def upload(lines: Sequence[str], digest: str, progress: Callable[[int, int], None]) -> Script:
    """``lines``: from ``language.script``. ``progress``: lines that the Pi has, and all lines."""
    sent: set[int] = set()
    try:
        return (yield from _missing(lines, digest, progress, sent))
    except Refused:
        if not 0 < len(sent) < len(lines):
            raise
    return (yield from _all(lines, digest, progress))


def _all(lines: Sequence[str], digest: str, progress: Callable[[int, int], None]) -> Script:
    """Send every line again. The Pi refused a set with lines that are not from this upload: they
    are somebody else's, or were damaged on their way. A refusal counts only if it stands after
    that."""
    for number in range(1, len(lines) + 1):
        with contextlib.suppress(Refused):
            yield from _line(lines, number, set())
        progress(number, len(lines))
    report = yield from asked_store()
    if report.digest == digest[:16] and report.state == "ready":
        return f"{len(lines)} lines stored, digest {report.digest}"
    raise Refused(report.refusal or "the vehicle does not say why")


def _missing(
    lines: Sequence[str], digest: str, progress: Callable[[int, int], None], sent: set[int]
) -> Script:
    """Send the lines that the Pi lacks; ``sent`` collects their numbers."""
    report = yield from asked_store()
    if report.state == "running":
        raise Refused(NOT_IDLE)
    if report.state == "ready" and report.digest == digest[:16]:
        return f"the vehicle holds it already, digest {report.digest}"
    total, failed, most = len(lines), 0, -1
    yield from _line(lines, 1, sent)
    while failed < ROUNDS:
        report = yield from asked_store()
        if report.digest == digest[:16] and report.state == "ready":
            progress(total, total)
            return f"{total} lines stored, digest {report.digest}"
        missing = _numbers(report, total)
        progress(total - len(missing) if report.state == "staging" else 0, total)
        have = report.have if report.state == "staging" else 0
        failed, most = (0 if have > most else failed + 1), max(have, most)
        for number in missing:
            yield from _line(lines, number, sent)
            progress(_have(number, missing, total), total)
        if not missing:  # complete, but not ours: its last line was refused, or it is another
            yield from _line(lines, total, sent)
    why = f": {report.refusal}" if report.refusal else ""
    raise NoAnswer(f"the upload does not get on at {report.have} of {report.total} lines{why}")


def _line(lines: Sequence[str], number: int, sent: set[int]) -> Generator[Ask, Answer | None, None]:
    """Raises Refused if the Pi gives a reason; a lost acknowledgement is no failure."""
    sent.add(number)
    command = MissionLine(len(lines), number, lines[number - 1])
    answer = yield Ask(f"line {number}", command, is_ack("A", "W"))
    if isinstance(answer, Ack) and not answer.ok:
        report = yield from asked_store()
        if report.refusal.startswith("AW"):
            raise Refused(report.refusal)


def _have(number: int, missing: Sequence[int], total: int) -> int:
    return total - len(missing) + missing.index(number) + 1


def _numbers(report: StoreReport, total: int) -> list[int]:
    """Return the numbers that ``missing`` names ("3-5.9"); every line if nothing is staged."""
    if report.state != "staging":
        return list(range(1, total + 1))
    numbers: list[int] = []
    for part in filter(None, report.missing.split(".")):
        first, _, last = part.partition("-")
        numbers += range(int(first), int(last or first) + 1)
    return [number for number in numbers if 1 <= number <= total]


def start(patience: int = 0) -> Script:
    """``patience``: how often a refusal is answered by a retry, a second apart."""
    for left in range(patience, -1, -1):
        answer = yield Ask("start", StartMission(), is_ack("A", "A"))
        if answer is None:
            raise NoAnswer("no answer to @AA: whether the mission started is not known; see status")
        if isinstance(answer, Ack) and answer.ok:
            return "started"
        report = yield from asked_store()
        if not left:
            raise Refused(report.refusal or "the vehicle does not say why")
        yield Ask("wait", StoreQuery(), lambda _: False, tries=1, by_clock=True)
    raise AssertionError


def start_telling(
    took: Callable[[str], None], patience: int = 0, named: str | None = None
) -> Script:
    """Start, and pass the mission's digest to ``took``, also if nobody answers: the mission may be
    under way, and the vehicle submerged. The digest is asked for first, while the vehicle is still
    heard. Raises Refused if the mission on board is not the one ``named``."""
    report = yield from asked_store()
    if named is not None and (not named or report.digest != named):
        raise Refused(f"on board is {report.digest or 'no mission'}, and not {named}")
    try:
        achieved = yield from start(patience)
    except NoAnswer:
        took(report.digest)
        raise
    took(report.digest)
    return achieved


def clear() -> Script:
    answer = yield Ask("clear", ClearMission(), is_ack("A", "C"), tries=1, waits=TRIES)
    if answer is None:
        raise NoAnswer("no answer to @AC: whether the mission is cleared is not known; see status")
    if isinstance(answer, Ack) and not answer.ok:
        report = yield from asked_store()
        raise Refused(report.refusal or "the vehicle does not say why")
    return "cleared"


def status(took: Callable[[Status, StoreReport | None], None]) -> Script:
    answer = yield Ask("status", DataQuery(), lambda a: isinstance(a, Status))
    if not isinstance(answer, Status):
        raise NoAnswer(f"no answer to @DU after {TRIES} tries; {WHAT_LISTENS}")
    report = yield Ask("store", StoreQuery(), is_report)
    took(answer, report if isinstance(report, StoreReport) else None)
    return ""


def asked_store() -> Generator[Ask, Answer | None, StoreReport]:
    report = yield Ask("store", StoreQuery(), is_report)
    if not isinstance(report, StoreReport):
        raise NoAnswer(f"no answer after {TRIES} tries; {WHAT_LISTENS}")
    return report


def is_report(answer: Answer) -> bool:
    return isinstance(answer, StoreReport)


def is_ack(group: str, function: str) -> Callable[[Answer], bool]:
    def fits(answer: Answer) -> bool:
        return isinstance(answer, Ack) and (answer.group, answer.function) == (group, function)

    return fits
