"""Every command of document 000 that a topside sends: checked, sent, and its answer awaited.
Sans-IO.

    word, values --command--> Command --say--> Script    (raises Refused, NoAnswer)

    NS ST SP AW   acknowledged by the Pi; N has its reason in @AR
    NI DU AQ AE   answered
    AA AC ZA      as start, clear (upload), stop and surface (orders)
    RS RI         answered by the STM32
    D and M       by nobody (E-F6): @AQ goes with them, in one piece, and its answer shows that they
                  arrived, or why they are refused; never repeated, since increments are among them

What does not live here: single letters of nodes and switches (switches), sockets (console).
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import asdict, replace
from typing import Any

from mission.topside.orders import order
from mission.topside.upload import (
    WHAT_LISTENS,
    Ask,
    NoAnswer,
    Refused,
    Script,
    asked_store,
    clear,
    is_ack,
    is_report,
    start,
)
from protocol.codec import CannotEncode
from protocol.fields import FrameType
from protocol.messages import (
    Ack,
    ClearMission,
    Command,
    DataQuery,
    Emergency,
    FrameFault,
    Manual,
    NodeQuery,
    Relay,
    SetTime,
    StartMission,
    StateQuery,
    StateReport,
    Status,
    StoreQuery,
    StoreReport,
)
from protocol.tolerances import Tolerances
from protocol.topside import (
    Answer,
    TopsideCodec,
    encode,
    status_values,
    to_pi_frames,
)
from protocol.topside_frames import NODES, SENSORS
from protocol.vehicles.stick import LACKS

SWITCH_TRIES = 7  # a second each: nodes may take 5 s to change (R13)
AGED = " ago"  # the end of an earlier refusal in @AR
UNACKNOWLEDGED = "the Pi has it and passes it on; no frame acknowledges it: watch it"
ELSEWHERE = (
    "no words for power (R) and rudders (D): what it has is set by its outputs, auvmission output"
)

Took = Callable[[Mapping[str, Any]], None]


def frame_types() -> dict[str, FrameType]:
    """Return the frame types by their names in the document, without ``auv.``."""
    return {f.name.removeprefix("auv."): f for f in to_pi_frames(Tolerances())}


def command(word: str, values: Mapping[str, Any]) -> Command:
    """Raises CannotEncode for a word that no topside may send, and for values that it does not
    have."""
    types = frame_types()
    if word not in types:
        raise CannotEncode(f"no word {word!r}; there are: {', '.join(sorted(types))}")
    raw = types[word].encode(values)
    carried = types[word].decode(raw)
    if idle := [name for name in values if name not in carried]:
        known = ", ".join(name for name in carried if name not in ("flags", "effective"))
        raise CannotEncode(f"{word} has no {', '.join(idle)}; its values are: {known or 'none'}")
    (read,) = TopsideCodec().receive(raw, 0.0)
    if isinstance(read, FrameFault):
        raise CannotEncode(f"{word}: no vehicle would take {raw!r} ({read.kind})")
    return read


def say(
    said: Command,
    took: Took = lambda values: None,
    tell: Callable[[str], None] = lambda words: None,
    *,
    under_water: bool = False,
) -> Script:
    """Return the script for a command. ``took`` gets the values of an answer that has any."""
    match said:
        case StartMission():
            return start()
        case ClearMission():
            return clear()
        case Emergency(order=which):
            return order(which, tell, under_water=under_water)
        case DataQuery() | StoreQuery() | StateQuery():
            return _told(said, took)
        case NodeQuery():
            return _mask(said, "NI", took)
        case Relay(kind="RI"):
            return _mask(said, "RI", took)
        case Relay(kind="RS"):
            return _power(said)
        case Relay() | Manual():
            return _unacknowledged(said, under_water)
        case _:
            return _acknowledged(said, under_water)


def _acknowledged(said: Command, under_water: bool) -> Script:
    if under_water and isinstance(said, SetTime):
        raise Refused("the time is not set by modem (R10)")
    code = encode(said)[1:3].decode("ascii")
    tries = SWITCH_TRIES if code == "NS" else 3
    answer = yield Ask(f"@{code}", said, is_ack(code[0], code[1]), tries=tries)
    if not isinstance(answer, Ack):
        raise NoAnswer(f"no answer to @{code}: whether it is done is not known; {WHAT_LISTENS}")
    if not answer.ok:
        report = yield from asked_store()
        raise Refused(report.refusal or "the vehicle does not say why")
    return f"@{code}: done"


def _told(said: DataQuery | StoreQuery | StateQuery, took: Took) -> Script:
    reports = (Status, StoreReport, StateReport)
    answer = yield Ask("status", said, lambda a: isinstance(a, reports))
    if isinstance(answer, Status):
        values: Mapping[str, Any] = status_values(answer)
    elif isinstance(answer, (StoreReport, StateReport)):
        values = asdict(answer)
    else:
        raise NoAnswer(f"no answer; {WHAT_LISTENS}")
    took(values)
    return "\n".join(f"{k:20} {v}" for k, v in values.items() if v not in (None, ""))


def _mask(said: NodeQuery | Relay, code: str, took: Took) -> Script:
    names = NODES if code == "NI" else SENSORS
    answer = yield from asked_mask(said, code)
    states = {name: bool(answer >> bit & 1) for bit, name in enumerate(names)}
    took(states)
    words = ("open", "closed") if code == "NI" else ("on", "off")
    return "\n".join(f"{name:13} {words[0 if is_on else 1]}" for name, is_on in states.items())


def asked_mask(said: NodeQuery | Relay, code: str) -> Generator[Ask, Answer | None, int]:
    """Part of a script: ask for the mask of @NI or @RI. Raises NoAnswer, Refused."""
    answer = yield from _relayed(said, code)
    return answer.result


def _relayed(said: Command, code: str) -> Generator[Ask, Answer | None, Ack]:
    """Return an answer from the Pi, or passed on by it. A vehicle without such a command sends an
    @AR, but only to a topside that has asked for one before (R14)."""
    if isinstance(said, Relay):
        yield from asked_store()
    fits = is_ack(code[0], code[1])
    answer = yield Ask(f"@{code}", said, lambda a: fits(a) or _refusal(a) != "")
    if isinstance(answer, StoreReport):
        raise Refused(_refusal(answer))
    if not isinstance(answer, Ack):
        raise NoAnswer(f"no answer to @{code}: what became of it is not known")
    return answer


def _power(said: Relay) -> Script:
    answer = yield from _relayed(said, "RS")
    if not answer.ok:
        raise Refused("the STM32 answers N")
    return "@RS: done"


def _unacknowledged(said: Relay | Manual, under_water: bool) -> Script:
    if under_water and isinstance(said, Manual):
        raise Refused("the stick does not work by modem (R6)")
    together = replace(said, frame=said.frame + encode(StoreQuery()))
    report = yield Ask(f"@{said.kind}", together, is_report, tries=1)
    if report is None:
        raise NoAnswer(f"no answer: whether @{said.kind} has arrived is not known; {WHAT_LISTENS}")
    if why := _refusal(report):
        raise Refused(why)
    return f"@{said.kind}: {UNACKNOWLEDGED}"


def _refusal(answer: Answer) -> str:
    """Return the new refusal of a relayed or stick command; "" if there is none."""
    why = answer.refusal if isinstance(answer, StoreReport) else ""
    is_ours = why.startswith(("relay:", "manual:")) and not why.endswith(AGED)
    return why.replace(LACKS, ELSEWHERE) if is_ours else ""
