"""An operator reads what happened in order, and a flood does not drown it."""

from __future__ import annotations

import linecache

import pytest

from mission.model import By, Evaluation, Step, Tx
from mission.onboard.serve.journal import (
    AGAIN_S,
    CAUSES,
    DEEPEST,
    OF_A_KIND,
    REMEMBERED,
    Journal,
    printed,
)


class Desk:
    def __init__(self) -> None:
        self.now, self.lines = 0.0, list[str]()
        self.journal = Journal(self.lines.append, lambda: self.now)


def test_the_same_thing_within_a_minute_is_told_once_and_then_counted() -> None:
    desk = Desk()
    for i in range(1000):
        desk.now = i * 0.01
        desk.journal.warning("10.0.0.1 floods")
    desk.journal.info("now idle/ready")
    assert desk.lines == ["warning: 10.0.0.1 floods", "info: now idle/ready"]
    desk.now = AGAIN_S
    desk.journal.settle()
    assert desk.lines[2:] == ["warning: 999 more of: 10.0.0.1 floods"]
    desk.journal.warning("10.0.0.1 floods")
    assert desk.lines[3:] == ["warning: 10.0.0.1 floods"]


def test_faults_are_always_told() -> None:
    desk = Desk()
    for _ in range(3):
        desk.journal.fault("a bug")
    assert desk.lines == ["fault: a bug"] * 3


def broken() -> None:
    raise ZeroDivisionError("no depth")


def test_an_error_is_told_with_its_place_and_kind_and_reads_no_source(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The card that has the source may hang."""

    def hangs(*_: object) -> list[str]:
        raise AssertionError("a source is read")

    desk = Desk()
    with monkeypatch.context() as patch:
        patch.setattr(linecache, "getlines", hangs)
        try:
            broken()
        except ZeroDivisionError as error:
            desk.journal.error("a fault of the program:", error)
    (told,) = desk.lines
    begin, *_, place, kind = told.split("\n")
    assert begin == "fault: a fault of the program:"
    assert place == f"  {__file__}:{broken.__code__.co_firstlineno + 1} broken"
    assert kind == "ZeroDivisionError: no depth"


class Wordless(Exception):
    def __str__(self) -> str:
        raise ValueError("no words")


def deep(n: int) -> None:
    if n:
        deep(n - 1)
    raise Wordless


def test_an_error_is_told_with_its_cause_and_is_no_error_of_the_journal() -> None:
    desk = Desk()
    try:
        try:
            broken()
        except ZeroDivisionError as cause:
            try:
                deep(100)
            except Wordless as error:
                raise error from cause
    except Wordless as error:
        desk.journal.error("a fault of the program:", error)
    rows = desk.lines[0].split("\n")
    caused = rows.index("caused by:")
    assert rows[caused - 1] == "Wordless"
    assert rows[-1] == "ZeroDivisionError: no depth"
    assert len(rows) < 2 * DEEPEST + 5


def test_an_error_that_causes_itself_or_a_thousand_others_ends() -> None:
    desk = Desk()
    one = ValueError("round")
    one.__context__ = ValueError("and round")
    one.__context__.__context__ = one
    desk.journal.error("a fault of the program:", one)
    assert desk.lines[0].count("and round") == 1
    for _ in range(5000):
        behind, one = one, ValueError("deep")
        one.__cause__ = behind
    desk.journal.error("a fault of the program:", one)
    assert desk.lines[1].count("ValueError: deep") == CAUSES


def test_ten_thousand_different_things_leave_no_memory_behind() -> None:
    desk = Desk()
    for i in range(10_000):
        desk.journal.warning(f"host {i}")
    assert len(desk.journal.told) <= REMEMBERED


@pytest.mark.parametrize("minutes", [1, 2, 5])
@pytest.mark.parametrize("a_second", [1, 10, 40])
@pytest.mark.parametrize("hosts", [1, 2, 1000])
def test_lines_a_minute_and_a_kind_are_bounded_however_many_and_fast_they_come(
    hosts: int, a_second: int, minutes: int
) -> None:
    """One line and one count of each thing, of ``OF_A_KIND`` things and of the rest as one."""
    desk, kinds = Desk(), ("turned away", "arrivals")
    for i in range(int(minutes * AGAIN_S * a_second)):
        desk.now = i / a_second
        for kind in kinds:
            desk.journal.warning(f"{i % hosts} {kind}", kind=kind)
        if i % a_second == 0:
            desk.journal.settle()
    things = min(hosts, OF_A_KIND + 1)
    for kind in kinds:
        told = sum(kind in line for line in desk.lines)
        assert things <= told <= 2 * things * minutes


def test_what_is_beyond_the_lines_of_its_kind_is_counted_and_other_kinds_are_told() -> None:
    desk = Desk()
    for i in range(OF_A_KIND + 7):
        desk.journal.warning(f"host {i}", kind="turned away")
    desk.journal.warning("the port is away")
    desk.now = AGAIN_S
    desk.journal.settle()
    told = f"turned away: beyond {OF_A_KIND} different ones a minute they are counted"
    assert desk.lines[OF_A_KIND:] == [
        f"warning: {told}",
        "warning: the port is away",
        f"warning: 6 more of: {told}",
    ]


def test_every_command_to_the_vehicle_is_told_with_its_reason_and_a_stick_once() -> None:
    desk = Desk()
    desk.journal.commanded(Tx(0.0, "vehicle", b"@ZAS5$", "entry of dive"), True)
    desk.journal.commanded(Tx(0.1, "vehicle", b"@ZAH0,4$", "entry of dive"), True)
    for gear in range(12):
        desk.journal.commanded(Tx(0.2, "vehicle", b"@MMF%d$" % gear, "relay of @MM"), True)
    desk.journal.answered(Tx(0.3, "topside", b"@ACK_AAN$", "AA: no fix", "10.0.0.1:4"))
    desk.journal.answered(Tx(0.3, "topside", b"@VS2025$", "asked", "10.0.0.1:4"))
    assert desk.lines == [
        "info: to the vehicle: @ZAS5$ - entry of dive",
        "info: to the vehicle: @ZAH0,4$ - entry of dive",
        "info: to the vehicle: @MMF0$ - relay of @MM",
        "warning: refused: @ACK_AAN$ to topside 10.0.0.1:4 - AA: no fix",
    ]


def test_a_command_that_is_sent_again_in_another_state_is_told_again() -> None:
    desk = Desk()
    again = Tx(0.0, "vehicle", b"@ZAS5$", "entry of dive")
    for path in ("autonomous/dive", "manual/waiting", "autonomous/dive"):
        desk.journal.step(Step(0.0, "x", (), (), (path,), ()))
        if path.startswith("autonomous"):
            desk.journal.commanded(again, True)
            desk.journal.commanded(again, True)
    told = "info: to the vehicle: @ZAS5$ - entry of dive"
    assert desk.lines.count(told) == 2
    assert desk.lines[2] == "info: 1 more of: to the vehicle: @ZAS5$ - entry of dive"


def test_what_did_not_leave_is_not_told_as_sent() -> None:
    desk = Desk()
    desk.journal.commanded(Tx(0.0, "vehicle", b"@ZAWF$", "W from the operator"), False)
    desk.journal.commanded(Tx(0.5, "vehicle", b"@ZAWF$", "W from the operator"), True)
    assert desk.lines == [
        "warning: NOT SENT, the port is closed: @ZAWF$ - W from the operator",
        "info: to the vehicle: @ZAWF$ - W from the operator",
    ]


def test_the_system_journal_gets_levels_and_a_terminal_times(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("JOURNAL_STREAM", raising=False)
    assert printed("warning: x", 0.0) == "1970-01-01T00:00:00Z warning x"
    monkeypatch.setenv("JOURNAL_STREAM", "8:1")
    assert printed("fault: two\nrows", 0.0) == "<3>two\n<3>rows"
    assert printed("no level: x", 0.0) == "<6>no level: x"


def test_what_is_only_held_is_not_told_again_and_what_cannot_leave_is() -> None:
    desk = Desk()
    for reason in ("row1 steers", "row1 steers (held)"):
        desk.journal.commanded(Tx(1.0, "vehicle", b"\xfe\x02", reason), sent=True)
    assert desk.lines == ["info: to the vehicle: fe 02 - row1 steers"]
    desk.journal.commanded(Tx(1.0, "vehicle", b"\xfe\x02", "row1 steers (held)"), sent=False)
    assert desk.lines[1].startswith("warning: NOT SENT, the port is closed: fe 02 - row1 steers")
    for _ in range(2):
        desk.journal.commanded(Tx(1.0, "vehicle", b"\xfe\x02", "row1 steers (held)"), sent=True)
    assert desk.lines[2:] == ["info: to the vehicle: fe 02 - row1 steers (held)"], "it leaves again"


def test_a_limit_that_needs_no_command_is_told_by_its_name() -> None:
    """The ascent was under way already; what came in then was a report."""
    desk = Desk()
    seen = (Evaluation("limit radius", True, (("depth", 0.3),)),)
    entered = ("emergency", "emergency/surfacing")
    desk.journal.step(Step(9.0, "telemetry", seen, (), entered, (), "limit", By.LIMIT))
    (line,) = desk.lines
    assert "limit radius: the radius in force" in line
    assert "telemetry" not in line
