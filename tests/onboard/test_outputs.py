"""Outputs beside the motion, over the whole runtime and the vehicles' own bytes: by legs, by hand,
and safe in every emergency (R18)."""

from __future__ import annotations

from pathlib import Path

import pytest
from test_other_vehicles import prepared
from test_sticks import AHEAD, Bench

from links.base import Rx
from mission.model import MANUAL_DRIVING, SURFACING, Outcome, Result, Tx
from mission.model.running import Action
from mission.model.shipped import load_vehicle
from mission.model.vehicle_file import read_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.frontseat import Frontseat
from mission.onboard.runtime.line import line_to
from mission.onboard.runtime.repeater import Repeater
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve.leaving import LAST_WORDS_S, MARGIN_S, REBORN_S
from mission.onboard.store import MemoryStore
from mission.verification.rig.rehearsal import Cue
from mission.verification.simulation.flight import fly
from protocol.codec import CannotEncode
from protocol.messages import Ack, Order, Outputs, Setpoint
from protocol.vehicles import codec

LAMP = b"@AO,lamp,40,$"
DONE, REFUSED = b"@ACK_AOO$", b"@ACK_AON$"
ROV = """mission rov-lamp vehicle rov
safety time 20min depth 20
assume current 0
start without fix
dive: down 9 output lamp 80 until depth >= 2 timeout 30s
stay: down 5 for 5s
dark: down 5 output lamp 0 output servo -10 for 5s
up: surface timeout 3min
"""


def led(bench: Bench, since: float = 0.0) -> list[int]:
    """What the board was told of it, one after the other."""
    said = [int(bench.values(tx)["led_pct"]) for tx in bench.to_board(since)]
    return [level for i, level in enumerate(said) if i == 0 or level != said[i - 1]]


def answers(bench: Bench, word: bytes) -> list[bytes]:
    before = len(bench.sent)
    bench.say(word)
    return [tx.data for tx in bench.sent[before:] if tx.link == "topside"]


def test_an_output_is_set_by_hand_and_acknowledged_and_seen_on_the_wire_until_x() -> None:
    bench = Bench("rov")
    bench.until(1.0)
    assert answers(bench, LAMP) == [DONE]
    bench.until(3.0)
    assert led(bench) == [40]
    assert "output lamp 40: outputs in idle/empty" in bench.journal.steps[-1].actions
    bench.say(b"@ZAX0$")
    bench.until(5.0)
    assert led(bench) == [40, 0]


@pytest.mark.parametrize("state", ["emergency/stopped", SURFACING])
def test_an_emergency_holds_every_output_safe(state: str) -> None:
    bench = Bench("rov")
    bench.until(1.0)
    bench.come_to(state)
    bench.until(2.0)
    assert answers(bench, LAMP) == [REFUSED]
    assert b"an emergency holds lamp at 0" in answers(bench, b"@AQ$")[0]
    bench.until(4.0)
    assert led(bench) == [0]


@pytest.mark.parametrize(
    ("word", "why"),
    [
        (b"@AO,lamp,101,$", b"lamp 101 is outside 0 to 100 %"),
        (b"@AO,lamp,1.5,$", b"lamp 1.5 is not a whole number"),
        (b"@AO,beam,1,$", b"no output beam; the vehicle file names: lamp; servo"),
        (b"@AO,hold_depth,1,$", b"hold_depth moves or holds the vehicle: take the stick first"),
    ],
)
def test_what_the_vehicle_file_does_not_allow_is_refused_with_its_reason(
    word: bytes, why: bytes
) -> None:
    bench = Bench("rov")
    bench.until(1.0)
    assert answers(bench, word) == [REFUSED]
    assert why in answers(bench, b"@AQ$")[0]
    bench.until(3.0)
    assert not bench.to_board(0.0)


def test_an_output_is_the_commanders_to_set() -> None:
    bench = Bench("rov")
    bench.until(1.0)
    assert answers(bench, LAMP) == [DONE]
    bench.sent += bench.runtime.connected("topside", "tender", 1.0)
    assert bench.said_by("tender", LAMP)[-1] == REFUSED


def test_what_holds_the_vehicle_is_set_under_the_stick_and_ends_with_it() -> None:
    bench = Bench("rov")
    bench.until(1.0)
    bench.say(AHEAD)
    assert answers(bench, b"@AO,hold_depth,1,$") == [DONE]
    bench.until(1.3)
    flags = [bench.values(tx)["hold_depth"] for tx in bench.to_board(1.1)]
    assert set(flags) == {1}
    bench.until(4.0)  # let go
    assert {bench.values(tx)["hold_depth"] for tx in bench.to_board(1.7)} == {0}
    bench.say(AHEAD)
    assert bench.runtime.state == MANUAL_DRIVING
    bench.until(4.3)
    assert {bench.values(tx)["hold_depth"] for tx in bench.to_board(4.0)} == {0}


@pytest.mark.parametrize("away", [False, True])
def test_no_side_move_outlives_its_stick_though_the_line_was_away(away: bool) -> None:
    bench = Bench("robot")
    bench.until(1.0)
    bench.say(AHEAD)
    bench.say(b"@AO,side,7,$")
    bench.until(1.5)
    if away:
        bench.sent += bench.runtime.connected("vehicle", "", bench.now)
    bench.until(6.0)  # let go
    bench.say(b"@MMF0$")
    bench.until(6.5)
    assert bench.runtime.state == MANUAL_DRIVING
    assert {bench.values(tx)["command"] for tx in bench.to_board(6.0)} == {0}


def test_a_lamp_is_off_at_the_end_of_the_program_though_the_line_was_away() -> None:
    bench = Bench("rov")
    bench.until(1.0)
    bench.say(LAMP)
    bench.until(2.0)
    bench.sent += bench.runtime.connected("vehicle", "", bench.now)
    bench.sent += bench.runtime.end(bench.now)
    bench.until(4.0)
    assert led(bench) == [40, 0]


def test_a_leg_sets_its_outputs_the_next_keeps_them_and_the_ascent_makes_them_safe(
    tmp_path: Path,
) -> None:
    ready = prepared(tmp_path, ROV)
    said = (Cue(4.0, b"@AO,lamp,10,$"), Cue(4.2, b"@AO,servo,5,$"), Cue(4.4, b"@AQ$"))
    flight = fly(ready.mission, ready.vehicle, seed=3, said=said)
    assert flight.outcome == "completed", flight.reason
    bench = Bench("rov")
    bench.sent = list(flight.sent)
    values = [bench.values(tx) for tx in bench.to_board(0.0)]
    pairs = [(v["led_pct"], v["servo_deg"]) for v in values]
    changes = [pair for i, pair in enumerate(pairs) if i == 0 or pair != pairs[i - 1]]
    assert changes == [(80, 0), (0, -10), (0, 0)]
    refused = [tx.data for tx in flight.sent if tx.link == "topside" and b"AON" in tx.data]
    assert refused == [REFUSED, REFUSED]


def test_a_neutral_stick_ends_a_side_move_that_the_mission_began(tmp_path: Path) -> None:
    text = """mission aside vehicle robot
safety time 20min
assume start 0
start without fix
aside: stop output side 7 output side_speed 400 for 30s
"""
    ready = prepared(tmp_path, text)
    said = tuple(Cue(15.0 + 0.2 * i, b"@MMF0$") for i in range(10))
    flight = fly(ready.mission, ready.vehicle, seed=3, said=said)
    bench = Bench("robot")
    bench.sent = list(flight.sent)
    taken = next(tx.t for tx in bench.to_board(0.0) if "@MM" in tx.reason)
    before = [bench.values(tx)["command"] for tx in bench.to_board(0.0) if tx.t < taken]
    assert before[-1] == 7
    assert {bench.values(tx)["command"] for tx in bench.to_board(taken)} == {0}


@pytest.mark.proof
def test_a_mission_that_names_no_output_leaves_what_was_set_by_hand(tmp_path: Path) -> None:
    text = ROV.replace(" output lamp 80", "").replace(" output lamp 0", "")
    ready = prepared(tmp_path, text)
    flight = fly(ready.mission, ready.vehicle, seed=3, said=(Cue(8.0, LAMP),))
    bench = Bench("rov")
    bench.sent = list(flight.sent)
    told = [bench.values(tx)["led_pct"] for tx in bench.to_board(13.2)]
    assert set(told) == {40}


# --- words of their own --------------------------------------------------------------------------


def test_the_gimbal_is_told_three_times_and_nothing_else_is_said_to_the_robot() -> None:
    bench = Bench("robot")
    bench.until(1.0)
    assert answers(bench, b"@AO,gimbal_yaw,12.5,$") == [DONE]
    bench.until(10.0)
    (angles,) = {tx.data for tx in bench.to_board(0.0)}
    assert angles == bytes.fromhex("AA 02 02 04 E2 04 00 00 00 00 99 DD")
    times = [round(tx.t, 3) for tx in bench.to_board(0.0)]
    assert times == [1.0, 3.0, 5.0]


@pytest.mark.parametrize(("first", "then"), [(60.0, 0.0), (0.0, 60.0)])
def test_a_newer_word_for_the_gimbal_takes_the_place_of_the_older_the_centre_too(
    first: float, then: float
) -> None:
    vehicle = load_vehicle("robot")
    line = line_to(codec(*vehicle.speaks), "vehicle", "serial:///x", vehicle)

    def told(yaw: float, until: float) -> list[bytes]:
        line.command(Action(Outputs((("gimbal_yaw", yaw),)), "a leg"))
        said, now = list[Tx](), 0.0
        while (due := line.next_timer()) is not None and due <= until:
            now = max(now, due)
            said += line.poll(now)[0]
        return [tx.data for tx in said if tx.data[1] == 2]

    assert len(told(first, 0.5)) == 1
    newer = told(then, 10.0)
    assert newer == [newer[0]] * 3
    assert newer[0][2] == (2 if then else 0)


AUV = Path("missions/vehicles/auv.yaml").read_text(encoding="utf-8") + (
    "outputs:\n"
    "  port: {channel: rudder_left_deg, low: -10, high: 10, safe: 0}\n"
    "  light: {channel: power_light, safe: 0}\n"
)


def auv_line() -> Frontseat:
    vehicle = read_vehicle(AUV, "auv.yaml")
    line = line_to(codec(*vehicle.speaks), "vehicle", "serial:///x", vehicle)
    assert isinstance(line, Frontseat)
    return line


def drained(line: Frontseat, until: float, answers: bool = True) -> list[tuple[float, bytes]]:
    sent, now = [], 0.0
    while (due := line.next_timer()) is not None and due <= until:
        now = max(now, due)
        out, _ = line.poll(now)
        for tx in out:
            sent.append((now, tx.data))
            if answers and tx.data.startswith(b"@ZA"):
                assert isinstance(line.answer(Ack(now, "Z", "A", ord("Y")), now), Outcome)
    return sent


def test_rudders_and_power_go_behind_an_order_and_an_order_does_not_drop_them() -> None:
    line = auv_line()
    line.command(Action(Outputs((("light", 0.0), ("port", 5.0))), "safe"))
    line.command(Action(Order.STOP, "X"))
    sent = [data for _, data in drained(line, 10.0)]
    assert sent[0] == b"@ZAX0$"
    assert [sent.count(word) for word in (b"@DS1,5$", b"@RSOOOOOOC$")] == [3, 3]


def test_a_newer_word_for_the_same_output_takes_the_place_of_the_older() -> None:
    line = auv_line()
    line.command(Action(Outputs((("port", 5.0),)), "a leg"))
    assert [data for _, data in drained(line, 0.5)] == [b"@DS1,5$"]
    line.command(Action(Outputs((("port", -3.0),)), "another leg"))
    assert [data for _, data in drained(line, 10.0)] == [b"@DS1,-3$"] * 3


@pytest.mark.parametrize("relayed", [b"@DS1,15$", b"@DA1,2$", b"@DS3,15$", b"@MDS1,15$"])
def test_an_operators_own_word_takes_the_place_of_an_older_one_for_the_same_rudder(
    relayed: bytes,
) -> None:
    line = auv_line()
    line.command(Action(Outputs((("light", 0.0), ("port", 0.0))), "safe"))
    said = [data for _, data in drained(line, 1.0)]
    line.relay(relayed, "operator", relayed.startswith(b"@M"))
    said += [data for _, data in drained(line, 10.0)]
    assert said.count(b"@RSOOOOOOC$") == 3
    assert [data for data in said if data[:2] in (b"@D", b"@M")] == [b"@DS1,0$", relayed]


def test_what_an_operators_own_word_adds_to_is_said_before_it() -> None:
    line = auv_line()
    line.command(Action(Outputs((("port", 0.0),)), "safe"))
    line.relay(b"@DA1,2$", "operator")
    assert [data for _, data in drained(line, 10.0)] == [b"@DS1,0$", b"@DA1,2$"]


def test_what_was_relayed_to_a_device_is_made_safe_by_the_next_emergency() -> None:
    vehicle = read_vehicle(AUV, "auv.yaml")
    runtime = Runtime(Configuration(), vehicle, MemoryStore())
    sent = runtime.connected("topside", "boat", 0.0)
    said = ((1.0, b"@ZAX0$"), (15.0, b"@DS1,9$@RSCCCCCCC$"), (30.0, b"@ZAX0$"))
    for now, words in said:
        sent += runtime.receive(Rx(now, "topside", words, "boat"))
        while (due := runtime.next_timer()) is not None and due < now + 14.0:
            sent += runtime.handle_timer(due)
            if sent[-1].data == b"@ZAX0$":
                sent += runtime.receive(Rx(due, "vehicle", b"@ACK_ZAY$"))
    devices = [tx.data for tx in sent if tx.link == "vehicle" and tx.data[:2] in (b"@D", b"@R")]
    safe = [b"@RSOOOOOOC$", b"@DS1,0$"]
    told = [sorted(devices[:6]), sorted(devices[6:8]), sorted(devices[8:])]
    assert told == [sorted(3 * safe), [b"@DS1,9$", b"@RSCCCCCCC$"], sorted(3 * safe)]


def test_the_program_ends_behind_the_third_word_to_every_output() -> None:
    runtime = Runtime(Configuration(), read_vehicle(AUV, "auv.yaml"), MemoryStore())
    sent = runtime.end(1.0)
    while not runtime.said_all:
        due = runtime.next_timer()
        assert due is not None
        sent += runtime.handle_timer(due)
    words = [tx.data for tx in sent if tx.link == "vehicle"]
    assert words.count(b"@DS1,0$") == words.count(b"@RSOOOOOOC$") == 3
    assert sent[-1].t - 1.0 < LAST_WORDS_S
    assert LAST_WORDS_S + REBORN_S < MARGIN_S


def no_word(wanted: Outputs) -> dict[str, bytes]:
    raise CannotEncode("no word for it")


def test_an_output_that_has_no_word_is_refused_and_what_holds_goes_on() -> None:
    board = codec(*load_vehicle("robot").speaks)
    for line in (
        Repeater(board.encode, 0.1, take_outputs=no_word),
        Frontseat(codec(*load_vehicle("auv").speaks).encode, take_outputs=no_word),
    ):
        line.command(Action(Setpoint(surge=0.5), "a leg"))
        wanted = Outputs((("side_speed", 4000.0),))
        refused = line.command(Action(wanted, "by hand"))
        assert refused == Outcome(Result.REFUSED, b"no word for it", wanted)
        assert line.poll(0.0)[0]


def test_what_a_set_waits_for_is_not_kept_back_by_outputs() -> None:
    line = auv_line()
    line.command(Action(Outputs((("port", 5.0),)), "a leg"))
    line.command(Action(Setpoint(surge=0.5), "a leg"))
    sent = [data for _, data in drained(line, 1.0)]
    assert [data[:3] for data in sent] == [b"@ZA", b"@ZA", b"@DS"]
