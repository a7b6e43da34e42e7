"""Laws of the operator's side: whatever the line loses, doubles or garbles, it ends in the truth."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest
from pool_mission import DIGEST, LINES, TEXT

from links.base import Rx
from mission.authoring.language import digest, parse, script
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.store import MemoryStore
from mission.topside.orders import Unconfirmed, order
from mission.topside.upload import (
    TRIES,
    Conversation,
    NoAnswer,
    Refused,
    Script,
    clear,
    start,
    start_telling,
    status,
    upload,
)
from protocol.messages import Ack, MissionLine, Order, Status, StoreReport
from protocol.topside import encode


class Wire:
    """A Pi in memory at the other end; ``loses`` decides frame by frame, both ways."""

    def __init__(self, loses: Callable[[], bool] = lambda: False, copies: int = 1) -> None:
        self.store = MemoryStore()
        self.runtime = Runtime(Configuration(), load_vehicle("auv"), self.store)
        self.loses, self.copies = loses, copies
        self.now, self.sent = 0.0, []
        self.garbage = b""

    def hold(self, talk: Script, most: int = 10_000) -> Conversation:
        """Until it is over, or ``most`` frames were sent (a cut)."""
        conversation = Conversation(talk)
        out = conversation.begin(self.now)
        while not conversation.over:
            heard = b""
            for frame in out:
                if len(self.sent) >= most:
                    return conversation
                heard += self.cross(frame)
            self.now += 0.01
            out = conversation.receive(self.garbage + heard, self.now) if heard else []
            if not out and not conversation.over:
                due = conversation.next_timer()
                assert due is not None
                self.now = max(self.now, due)
                out = conversation.handle_timer(self.now)
        return conversation

    def cross(self, frame: bytes) -> bytes:
        self.sent.append(frame)
        if self.loses():
            return b""
        answers = self.runtime.receive(Rx(self.now, "topside", frame, "boat"))
        frames = [tx.data for tx in answers if tx.link == "topside"]
        return b"".join(frame * self.copies for frame in frames if not self.loses())

    def cut(self) -> None:
        self.runtime.disconnected("topside", "boat", self.now)
        self.sent.clear()


def quiet(have: int, total: int) -> None:
    """Nobody watches."""


def test_an_upload_is_stored_and_its_lines_are_told() -> None:
    wire, told = Wire(), []
    talk = wire.hold(upload(LINES, DIGEST, lambda have, total: told.append((have, total))))
    assert talk.failure is None
    assert wire.store.content.lines == tuple(LINES)
    assert [have for have, _ in told if have][-1] == len(LINES)
    assert [have for have, _ in told] == sorted(have for have, _ in told)
    assert sum(frame.startswith(b"@AW") for frame in wire.sent) == len(LINES)


def test_what_is_there_already_is_not_sent_again() -> None:
    wire = Wire()
    wire.hold(upload(LINES, DIGEST, quiet))
    wire.cut()
    talk = wire.hold(upload(LINES, DIGEST, quiet))
    assert talk.result is not None
    assert "already" in talk.result
    assert not any(frame.startswith(b"@AW") for frame in wire.sent)


def test_an_upload_that_was_cut_goes_on_where_it_stopped() -> None:
    wire = Wire()
    wire.hold(upload(LINES, DIGEST, quiet), most=8)
    first = sum(frame.startswith(b"@AW") for frame in wire.sent)
    assert 2 < first < len(LINES)
    wire.cut()
    assert wire.hold(upload(LINES, DIGEST, quiet)).failure is None
    again = sum(frame.startswith(b"@AW") for frame in wire.sent)
    assert again == len(LINES) - first + 1  # line 1 says which mission it is
    assert wire.store.content.lines == tuple(LINES)


@pytest.mark.parametrize("seed", range(8))
def test_lost_frames_are_sent_again_until_the_digest_agrees(seed: int) -> None:
    chance = random.Random(seed)
    wire = Wire(lambda: chance.random() < 0.2)
    talk = wire.hold(upload(LINES, DIGEST, quiet))
    if talk.failure is None:
        assert wire.store.content.lines == tuple(LINES)
    else:
        assert isinstance(talk.failure, NoAnswer)
        assert wire.store.content.lines == ()


def test_more_missing_lines_than_one_report_can_name_are_all_sent() -> None:
    """A report has room for 120 characters of them; as long as it gets on, it goes on."""
    text = TEXT.replace(
        "up: surface",
        "".join(f"l{i}: heading {i} gear 4 for 1s\n" for i in range(300)) + "up: surface",
    )
    mission = parse(text)
    lines, wire = script(mission), Wire()
    for number in range(1, len(lines) + 1, 2):
        wire.cross(encode(MissionLine(len(lines), number, lines[number - 1])))
    wire.sent.clear()
    talk = wire.hold(upload(lines, digest(mission), quiet))
    assert talk.failure is None
    assert wire.store.content.lines == tuple(lines)
    sent = sum(frame.startswith(b"@AW") for frame in wire.sent)
    assert sent == len(lines) // 2 + 1  # those, and line 1 to see whether it is the same mission


def test_doubled_answers_never_make_a_line_count_as_stored() -> None:
    lost = iter([False] * 9 + [True] + [False] * 500)
    wire = Wire(lambda: next(lost), copies=2)
    assert wire.hold(upload(LINES, DIGEST, quiet)).failure is None
    assert wire.store.content.lines == tuple(LINES)


def test_garbage_between_the_answers_is_passed_over() -> None:
    wire = Wire()
    wire.garbage = b"@ACK_\x00\xff@VS,,,$$@A"
    assert wire.hold(upload(LINES, DIGEST, quiet)).failure is None


def test_a_line_that_somebody_else_staged_is_replaced() -> None:
    """Under the same line 1 and total: the sum refuses the set, and all of ours are sent."""
    wire = Wire()
    other = script(parse(TEXT.replace("heading 0", "heading 45")))
    wire.cross(encode(MissionLine(len(LINES), 1, LINES[0])))
    for number in range(2, len(LINES) + 1):
        wire.cross(encode(MissionLine(len(LINES), number, other[number - 1])))
    assert wire.hold(upload(LINES, DIGEST, quiet)).failure is None
    assert wire.store.content.lines == tuple(LINES)


def test_no_answer_after_three_tries_is_said_and_nothing_assumed() -> None:
    wire = Wire(lambda: True)
    talk = wire.hold(upload(LINES, DIGEST, quiet))
    assert isinstance(talk.failure, NoAnswer)
    assert len(wire.sent) == TRIES
    assert wire.now == pytest.approx(TRIES, abs=0.2)


def test_a_mission_that_the_vehicle_refuses_is_refused_with_its_reason() -> None:
    deep = parse(
        TEXT.replace("depth 3 ", "depth 9 ").replace("until depth >= 2.5 timeout 90", "for 30s")
    )
    endless = parse(TEXT.replace("time 20min", "time 1min"))
    assert deep.safety.depth == 10
    wire = Wire()
    talk = wire.hold(upload(script(endless), digest(endless), quiet))
    assert isinstance(talk.failure, Refused)
    assert str(talk.failure).startswith("AW: line ")
    assert wire.store.content.lines == ()


def test_the_mission_before_stays_when_the_new_one_is_refused() -> None:
    wire = Wire()
    wire.hold(upload(LINES, DIGEST, quiet))
    bad = parse(TEXT.replace("time 20min", "time 1min"))
    assert isinstance(wire.hold(upload(script(bad), digest(bad), quiet)).failure, Refused)
    assert wire.store.content.lines == tuple(LINES)


def test_a_start_that_is_refused_says_why_and_patience_asks_again() -> None:
    wire = Wire()
    talk = wire.hold(start())
    assert isinstance(talk.failure, Refused)
    assert "no mission is stored" in str(talk.failure)
    wire.sent.clear()
    talk = wire.hold(start(patience=2))
    assert isinstance(talk.failure, Refused)
    assert wire.sent.count(b"@AA$") == 3


@pytest.mark.parametrize(
    ("answer", "noted"), [(ord("A"), [DIGEST[:16]]), (ord("N"), []), (None, [DIGEST[:16]])]
)
def test_a_start_is_noted_though_nothing_is_heard_from_it_on_but_not_a_refused_one(
    answer: int | None, noted: list[str]
) -> None:
    """The vehicle dives: its answer to @AA may be its last, or lost."""
    began: list[str] = []
    talk = Conversation(start_telling(began.append))
    store = encode(StoreReport("ready", len(LINES), len(LINES), "", DIGEST[:16], "no fix"))
    verdict = b"" if answer is None else encode(Ack(0.0, "A", "A", answer))
    refused, asked = answer == ord("N"), False
    out, now = talk.begin(0.0), 0.0
    while not talk.over:
        heard = {b"@AA$": verdict, b"@AQ$": store if refused or not asked else b""}.get(out[0], b"")
        asked = asked or out == [b"@AA$"]
        now += 1.0
        out = talk.receive(heard, now) or talk.handle_timer(now)
    assert began == noted
    assert talk.result == ("started" if answer == ord("A") else None)


@pytest.mark.parametrize("named", ["0" * 16, ""])
def test_a_start_of_another_mission_than_is_on_board_is_not_said_and_not_noted(named: str) -> None:
    wire, began = Wire(), list[str]()
    wire.hold(upload(LINES, DIGEST, quiet))
    wire.sent.clear()
    talk = wire.hold(start_telling(began.append, named=named))
    assert isinstance(talk.failure, Refused)
    assert f"on board is {DIGEST[:16]}" in str(talk.failure)
    assert began == []
    assert b"@AA$" not in wire.sent


def test_clear_empties_the_store() -> None:
    wire = Wire()
    wire.hold(upload(LINES, DIGEST, quiet))
    assert wire.hold(clear()).result == "cleared"
    assert wire.store.content.lines == ()


@pytest.mark.parametrize("patience", [1.0, 11.0])
def test_a_clear_is_said_once_and_waited_for_as_long_as_three_tries(patience: float) -> None:
    """Said again it would be the operator's second wish (R7)."""
    talk = Conversation(clear(), lambda: patience)
    assert talk.begin(0.0) == [b"@AC$"]
    assert talk.handle_timer(3 * patience - 0.1) == []
    assert not talk.over
    assert talk.handle_timer(3 * patience) == []
    assert isinstance(talk.failure, NoAnswer)


@pytest.mark.parametrize(("which", "frame"), [(Order.STOP, b"@ZAX0$"), (Order.SURFACE, b"@ZAWF$")])
def test_an_order_without_the_vehicles_answer_is_never_called_done(
    which: Order, frame: bytes
) -> None:
    wire = Wire()
    talk = wire.hold(order(which))  # X more would put off that it is brought up: the Pi is stopped
    assert isinstance(talk.failure, Unconfirmed if which is Order.STOP else NoAnswer)
    assert "STM32 has not acknowledged" in str(talk.failure)
    assert wire.sent.count(frame) == 10
    silent = Wire(lambda: True).hold(order(which))
    assert "not known whether it arrived" in str(silent.failure)


def test_an_order_is_sent_until_it_is_answered_y_and_is_not_done_then() -> None:
    conversation = Conversation(order(Order.STOP))
    assert conversation.begin(0.0) == [b"@ZAX0$"]
    assert conversation.receive(encode(Ack(0.0, "Z", "X", ord("N"))), 0.1) == []
    assert conversation.receive(encode(Ack(0.0, "Z", "X", ord("Y"))), 0.2) == [b"@DU$"]
    assert not conversation.over


def test_status_brings_both_reports() -> None:
    wire, found = Wire(), []
    wire.hold(upload(LINES, DIGEST, quiet))
    talk = wire.hold(status(lambda told, store: found.append((told, store))))
    assert talk.failure is None
    (told, store) = found[0]
    assert isinstance(told, Status)
    assert isinstance(store, StoreReport)
    assert store.digest == DIGEST[:16]


def test_over_a_long_way_what_was_asked_is_not_given_up_before_it_can_be_answered() -> None:
    conversation = Conversation(start(), lambda: 5.0)
    assert conversation.begin(0.0) == [b"@AA$"]
    assert conversation.handle_timer(4.9) == []
    assert conversation.receive(encode(Ack(0.0, "A", "A", ord("A"))), 4.9) == []
    assert conversation.result == "started"


def test_an_order_is_said_again_each_second_however_long_the_way() -> None:
    conversation = Conversation(order(Order.STOP), lambda: 5.0)
    conversation.begin(0.0)
    assert [conversation.handle_timer(float(t)) for t in range(1, 10)] == [[b"@ZAX0$"]] * 9


def test_an_answer_to_nothing_is_dropped() -> None:
    conversation = Conversation(start())
    conversation.begin(0.0)
    conversation.receive(encode(Ack(0.0, "A", "W", ord("W"))), 0.1)
    assert not conversation.over
