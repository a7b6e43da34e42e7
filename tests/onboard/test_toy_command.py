"""An operator's command is one row: this file has a toy that nobody else knows, and it is seen from
the operator's program to the engine and back."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import pytest
from click.testing import CliRunner
from contracts import keep
from topside_world import BOAT, WATER, Pi

from mission.analysis.replay.replay import replay
from mission.authoring.prepare import prepare
from mission.cli import main
from mission.engine.core import Core
from mission.engine.orders import OrderRow, registered
from mission.model import By, Verdict
from mission.onboard.runtime.records import ListRecorder
from mission.topside.words import command, say
from mission.verification.rig.rehearsal import Cue
from mission.verification.simulation.flight import fly
from protocol.messages import Ack, Command
from protocol.operator_words import WORDS, OperatorWord
from protocol.reference import reference
from protocol.text import Int, Sep, TextFrame
from protocol.topside import ConsoleCodec, TopsideCodec, answer, encode
from protocol.vehicles import frame_types


@dataclass(frozen=True, slots=True)
class GiveUp:
    """The active leg is given up, as at its timeout; ``why`` is the operator's business."""

    why: int


FRAME = TextFrame("auv.AJ", "000 table 1.1.2, a reserved code", "@AJ", (Sep(","), Int("why", 0, 9)))


def give_up(core: Core, said: GiveUp) -> Verdict:
    run, chart = core.flying, core.chart
    assert run is not None
    assert chart is not None
    way = next((edge for edge in chart.leaving(run.leaf) if edge.by is By.TIMEOUT), None)
    if way is None:
        return Verdict(False, "this leg has no timeout to leave by")
    core.follow(way, ())
    return Verdict(True)


TOY = OrderRow(
    OperatorWord(
        "AJ",
        GiveUp,
        lambda tolerances: FRAME,
        lambda values: GiveUp(values["why"]),
        lambda said: {"why": said.why},
        "J",
        (b"@AJ,7$",),
    ),
    give_up,
    frozenset({"autonomous"}),
    by_modem=False,
)
SAID: Command = GiveUp(7)  # type: ignore[assignment]


@pytest.fixture(autouse=True)
def known() -> Iterator[None]:
    with registered(TOY):
        yield


def test_the_boat_and_the_pi_say_it_in_its_frame() -> None:
    assert encode(SAID) == b"@AJ,7$"
    assert TopsideCodec().receive(b"@AJ,7$", 0.0) == [SAID]
    assert encode(answer("AJ", True, 0.0)) == b"@ACK_AJJ$"
    (ack,) = ConsoleCodec().receive(b"@ACK_AJN$", 0.0)
    assert isinstance(ack, Ack)
    assert not ack.ok


def test_it_is_in_the_reference_of_the_protocol_with_its_example() -> None:
    assert "auv.AJ" in frame_types()
    section = reference().split("### auv.AJ\n")[1].split("\n### ")[0]
    assert "why" in section
    assert "@AJ,7$" in section


def test_the_operators_program_lists_it_says_it_and_waits_for_its_acknowledgement() -> None:
    ran = CliRunner().invoke(main, ["send", "--list"])
    assert "AJ   why=7" in ran.output
    assert command("AJ", {"why": 7}) == SAID
    script = say(SAID)
    ask = next(script)
    assert ask.command == SAID
    with pytest.raises(StopIteration) as done:
        script.send(answer("AJ", True, 0.0))
    assert done.value.value == "@AJ: done"


def test_the_pi_decides_acknowledges_and_refuses_it_over_the_modem() -> None:
    pi = Pi()
    assert pi.hear(SAID, 0.0, BOAT) == [b"@ACK_AJJ$"]
    assert pi.target.decided == [SAID]
    pi = Pi()
    pi.hear(SAID, 0.0, WATER)
    assert pi.target.decided == []


def test_it_is_flown_recorded_and_replayed_to_the_bit_and_refused_where_it_is_not_allowed() -> None:
    ready, recorder = prepare("harbour-survey"), ListRecorder()
    said = [Cue(60.0, encode(SAID))]
    flight = fly(ready.mission, ready.vehicle, seed=1, recorder=recorder, said=said)
    left = next(leg for leg in flight.legs if leg.by == "timeout")
    assert left.entered < 60.0 + flight.legs[0].entered <= left.left + 1.0
    assert any("operator @AJ" in step.event for step in flight.steps)
    assert replay(recorder.records).identical


def test_a_region_that_it_is_not_for_refuses_it_by_name() -> None:
    class Idle:
        region = "idle"

    verdict = TOY.obey(Idle(), SAID)  # type: ignore[arg-type]
    assert verdict == Verdict(False, "@AJ is for autonomous, not for idle")


def test_a_code_that_is_taken_or_that_says_no_is_refused() -> None:
    for code, letter in (("AA", "J"), ("RS", "J"), ("AK", "N")):
        row = OperatorWord(code, int, lambda _: FRAME, lambda v: 0, letter=letter)
        with pytest.raises(ValueError, match=code):
            WORDS.register(row)


def test_it_keeps_the_contract_of_words_and_orders() -> None:
    """Among it: every state hears it in the exhaustive proof, operators under stress say it."""
    keep("words", TOY.word)
    keep("orders", TOY)
