"""Every topside word by hand: checked, sent, answered; and what is not known is not called done."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from programs import run
from served import Running, read_now, running, silent_board, simulated, soon

from links import open_link
from links.simulated.pty import PtyVehicle
from mission.topside.switches import nodes, power
from mission.topside.underwater import Submerged
from mission.topside.upload import Ask, NoAnswer, Refused, Script
from mission.topside.words import UNACKNOWLEDGED, command, frame_types, say
from protocol.arq import Acoustics
from protocol.codec import CannotEncode
from protocol.examples import examples
from protocol.messages import (
    Ack,
    Manual,
    NodeSwitch,
    Relay,
    Setpoint,
    SetTime,
    StateReport,
    Status,
    StoreQuery,
    StoreReport,
    Telemetry,
)
from protocol.topside import Answer, encode
from protocol.vehicles import frame_types as all_types
from protocol.vehicles.motorcan import CanFrame, record
from protocol.vehicles.stick import steered

WORDS = {
    e.type.removeprefix("auv."): e.raw for e in reversed(examples()) if e.type.startswith("auv.")
}
QUIET = StoreReport("empty", 0, 0, "", "", "")
STATE = StateReport("idle", "nobody", 1, 2, None, None, None, 7, None, 31, None, 0, "", "")
SEEN = Status("2025-01-01T00:00:00", None, Telemetry(0.0, depth=3.2))


def plain(word: str) -> dict[str, Any]:
    values = frame_types()[word].decode(WORDS[word])
    return {k: v for k, v in values.items() if k not in ("flags", "effective")}


def held(talk: Script, *answers: Answer | None) -> tuple[str, list[Ask]]:
    """What is said in the end, where the vehicle answers so; and what it was asked."""
    asked, told = [next(talk)], list(answers)
    try:
        while True:
            asked.append(talk.send(told.pop(0)))
    except StopIteration as end:
        return str(end.value), asked


def ack(code: str, result: int | str) -> Ack:
    return Ack(0.0, code[0], code[1], result if isinstance(result, int) else ord(result))


# --- what can be said at all ---------------------------------------------------------------------


@pytest.mark.parametrize("word", [w for w in frame_types() if w != "ZA"])
def test_every_word_of_the_document_is_said_byte_for_byte(word: str) -> None:
    assert encode(command(word, plain(word))) == WORDS[word]


@pytest.mark.parametrize(("code", "raw"), [("X", b"@ZAX0$"), ("W", b"@ZAWF$")])
def test_a_stop_and_a_surfacing_are_words_as_well(code: str, raw: bytes) -> None:
    assert encode(command("ZA", {"code": code})) == raw


@pytest.mark.parametrize(
    ("word", "values"),
    [
        ("ZZ", {}),
        ("ZA", {"code": "F", "gear": 5}),
        ("SP", {"radius_m": 0, "minutes": 5, "depth_m": 5, "low_voltage_v": 10}),
        ("SP", {"radius": 10}),
        ("D", {"mode": "S", "servo": 1, "angle": 23}),
        ("MM", {"dir": "F", "speed": 13}),
        ("NS", {"switches": "OOOOO"}),
        ("AA", {"now": True}),
        ("ST", {"time": "2025-02-30T00:00:00"}),
    ],
)
def test_what_no_vehicle_would_take_is_never_sent(word: str, values: dict[str, Any]) -> None:
    with pytest.raises(CannotEncode):
        command(word, values)
    given = [f"{name}={value}" for name, value in values.items()]
    assert run("send", word, *given, "--to", "tcp://127.0.0.1:9").exit_code == 2


# --- conversations -------------------------------------------------------------------------------


def test_a_word_is_done_when_its_acknowledgement_has_come() -> None:
    said, asked = held(say(command("SP", plain("SP"))), ack("SP", "P"))
    assert said == "@SP: done"
    assert not asked[0].fits(ack("ST", "T"))


def test_a_refusal_has_the_vehicles_own_reason() -> None:
    why = StoreReport("running", 1, 1, "", "", "ST: the time is set in idle only")
    with pytest.raises(Refused, match="the time is set in idle only"):
        held(say(command("ST", plain("ST"))), ack("ST", "N"), why)


def test_without_an_answer_nothing_is_called_done() -> None:
    for word in ("SP", "ST", "NS", "AW", "NI"):
        with pytest.raises(NoAnswer):
            held(say(command(word, plain(word))), None)


@pytest.mark.parametrize(("word", "fields"), [("AQ", QUIET), ("AE", STATE), ("DU", SEEN)])
def test_what_is_asked_is_told_with_every_value_of_its_answer(word: str, fields: Answer) -> None:
    taken: dict[str, Any] = {}
    said, asked = held(say(command(word, {}), taken.update), fields)
    assert len(asked) == 1
    assert len(taken) > 5
    assert all(f"{name} " in said for name, value in taken.items() if value not in (None, ""))


@pytest.mark.parametrize("word", ["D", "MM", "MR", "MT", "MD", "MS", "MP"])
def test_what_nobody_acknowledges_is_said_once_and_the_store_is_asked_with_it(word: str) -> None:
    said, asked = held(say(command(word, plain(word))), QUIET)
    assert said.endswith(UNACKNOWLEDGED)
    (ask,) = asked
    assert ask.tries == 1
    assert encode(ask.command) == WORDS[word] + encode(StoreQuery())
    with pytest.raises(NoAnswer, match="not known"):
        held(say(command(word, plain(word))), None)


@pytest.mark.parametrize(
    ("refusal", "refused"),
    [
        ("relay: 8 steps of a rudder wait", True),
        ("manual: somebody else commands", True),
        ("manual: somebody else commands; 5 s ago", False),
        ("AA: no mission is stored", False),
    ],
)
def test_only_a_refusal_of_now_and_of_such_a_word_counts(refusal: str, refused: bool) -> None:
    told = StoreReport("empty", 0, 0, "", "", refusal)
    if refused:
        with pytest.raises(Refused):
            held(say(command("D", plain("D"))), told)
    else:
        held(say(command("D", plain("D"))), told)


def test_a_vehicle_without_the_word_says_so_where_a_mask_was_asked_for() -> None:
    none = StoreReport("empty", 0, 0, "", "", "relay: this vehicle has no @RI")
    with pytest.raises(Refused, match="has no @RI"):
        held(power({}), QUIET, none)


def test_whoever_asks_another_board_for_power_or_a_rudder_is_told_what_sets_its_devices() -> None:
    with pytest.raises(CannotEncode) as caught:
        steered(Setpoint(), b"@RI$", {})
    none = StoreReport("empty", 0, 0, "", "", f"relay: {caught.value}")
    for script in (power({}), power({"light": True})):
        with pytest.raises(Refused, match="auvmission output"):
            held(script, QUIET, none)
    with pytest.raises(Refused, match="auvmission output"):
        held(say(command("D", plain("D"))), none)


@pytest.mark.parametrize("angle", ["-16", "23", "30"])
def test_a_rudder_beyond_its_stops_is_refused_in_its_own_figures(angle: str) -> None:
    ran = run("rudder", "left", angle)
    assert ran.exit_code == 2
    assert f"{angle} is outside -15..22 deg" in ran.stderr


def test_a_switch_changes_the_nodes_that_are_named_and_no_other() -> None:
    said, asked = held(nodes({"CAMERA": True, "AUTO": False}), ack("NI", 0b100011), ack("NS", "S"))
    assert asked[1].command == NodeSwitch("OOCCOC")
    assert asked[1].tries == 7
    assert said == "@NS: done, OOCCOC sent: Pi, STM32, CAMERA and no other"


def test_power_is_switched_by_name_and_no_other_device_is() -> None:
    answers = (QUIET, ack("RI", 0b0110011), QUIET, ack("RS", "S"))
    _, asked = held(power({"light": True, "altimeter": False}), *answers)
    assert encode(asked[3].command) == b"@RSOCCCOOO$"


def test_the_radio_is_never_switched_off_whatever_the_board_tells_of_it() -> None:
    answers = (QUIET, ack("RI", 0b1000000), QUIET, ack("RS", "S"))
    _, asked = held(power({"altimeter": True}), *answers)
    assert encode(asked[3].command) == b"@RSOOCCOCO$"
    assert run("power", "radio=off").exit_code == 2


def test_a_device_whose_node_is_open_keeps_its_power() -> None:
    with pytest.raises(Refused, match="auvmission nodes BDGPS=closed"):
        held(power({"BDGPS": False}), ack("NI", 0b000100))


def test_a_node_is_not_opened_before_its_device_has_power() -> None:
    with pytest.raises(Refused, match="auvmission power UACM=on"):
        held(nodes({"UACM": True}), QUIET, ack("RI", 0))


@pytest.mark.parametrize("said", [SetTime("2025-01-01T00:00:00"), Manual("MM", b"@MMF5$")])
def test_what_the_rules_keep_from_the_modem_is_refused_on_the_boat(said: Any) -> None:
    talk = Submerged(say(said, under_water=True), Acoustics(100.0, 1000.0))
    assert talk.begin(0.0) == []
    assert isinstance(talk.failure, Refused)


def test_under_water_the_whole_report_behind_a_rudder_is_waited_for() -> None:
    frame = WORDS["D"]
    slow = Acoustics(100.0, 100.0)
    talks = [Submerged(say(said), slow) for said in (Relay("D", frame), StoreQuery())]
    due = []
    for talk in talks:
        talk.begin(0.0)
        due.append(talk.next_timer())
    assert due[0] is not None
    assert due[1] is not None
    assert due[0] >= due[1]


# --- over real bytes -----------------------------------------------------------------------------


@contextmanager
def vehicle(folder: Path) -> Iterator[tuple[Running, PtyVehicle]]:
    with simulated(4.0) as sea:
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        with running(folder, stm32, gps=gps, speed=4.0) as pi:
            yield pi, sea


def test_the_words_before_a_dive_are_acknowledged_by_a_vehicle(tmp_path: Path) -> None:
    with vehicle(tmp_path) as (pi, sea):
        to = ("--to", pi.url)
        assert run("limits", "--radius", "120", "--depth", "8", *to).exit_code == 0
        assert pi.store.content.limits.radius == 120.0
        assert run("limits", "--time", "7.5", *to).exit_code == 0
        assert (pi.store.content.limits.time, pi.store.content.limits.depth) == (450.0, 8.0)
        assert run("time", "--at", "2025-01-11T16:56:06", *to).exit_code == 0
        assert "2025-01-11T16:56" in run("send", "DU", *to, "--json").stdout
        found = json.loads(run("power", *to, "--json").stdout)
        assert found["ok"]
        assert found["power"]["CTD"] is True
        assert run("power", "light=on", *to).exit_code == 0
        assert sea.vehicle.stm32.power == [True] * 7
        assert run("nodes", "auto=closed", *to).exit_code == 0
        assert "AUTO          closed" in run("nodes", *to).stdout
        assert run("nodes", "AUTO=open", *to).exit_code == 0
        refused = run("send", "AA", *to)
        assert refused.exit_code == 1
        assert "refused: AA: no mission is stored" in refused.stderr
        for asking in ("AQ", "AE"):
            assert '"state"' in run("send", asking, *to, "--json").stdout


def test_a_rudder_and_a_stick_are_seen_on_the_boards_wire_once(tmp_path: Path) -> None:
    with silent_board() as (master, device), running(tmp_path, f"serial://{device}") as pi:
        read_now(master)
        assert run("rudder", "both", "-5", "--to", pi.url).exit_code == 0
        assert run("rudder", "left", "-2", "--step", "--to", pi.url).exit_code == 0
        assert run("send", "MM", "dir=F", "speed=5", "--to", pi.url).exit_code == 0
        wire, words = bytearray(), (b"@DS3,-5$", b"@DA1,-2$", b"@MMF5$")

        def all_there() -> bool:
            wire.extend(read_now(master))
            return all(word in wire for word in words)

        soon(all_there, "every word")
    assert [wire.count(word) for word in words] == [1, 1, 1]


def test_where_nobody_answers_exit_1_says_that_nothing_is_known(tmp_path: Path) -> None:
    ran = run("limits", "--depth", "5", "--to", "tcp://127.0.0.1:9", "--json")
    assert ran.exit_code == 1
    assert json.loads(ran.stdout)["ok"] is False


# --- straight to a board -------------------------------------------------------------------------


@pytest.mark.parametrize(
    "words",
    [
        ("MM", "dir=F", "speed=5"),
        ("--text", "@MMF5$"),
        ("--hex", "40 4D 4D 46 35 24"),
    ],
)
def test_a_frame_goes_to_a_port_that_is_free_as_it_is(words: tuple[str, ...]) -> None:
    with silent_board() as (master, device):
        assert run("send", "--port", f"serial://{device}", *words).exit_code == 0
        assert read_now(master) == b"@MMF5$"


def test_what_a_board_answers_is_shown() -> None:
    with silent_board() as (master, device):
        over = threading.Event()

        def answer() -> None:
            while not over.wait(0.01):
                if b"@RI$" in read_now(master):
                    os.write(master, b"@ACK_RI\x11$")

        thread = threading.Thread(target=answer)
        thread.start()
        try:
            words = ("RI", "--link", "auv.from_stm32", "--json")
            ran = run("send", "--port", f"serial://{device}", *words)
        finally:
            over.set()
            thread.join()
    assert json.loads(ran.stdout)["values"]["mask"] == 0x11


@pytest.mark.parametrize("name", [e.type for e in examples() if not e.type.startswith("auv.")])
def test_every_frame_of_the_other_documents_is_sent_by_name(name: str) -> None:
    frame = all_types()[name]
    raw = next(e.raw for e in examples() if e.type == name)
    given = [f"{k}={json.dumps(v)}" for k, v in frame.decode(raw).items() if k != "flags"]
    if isinstance(frame, CanFrame):
        pytest.importorskip("can", reason="python-can is not installed")
        bus = open_link("board", "can://hand?interface=virtual")
        ran = run("send", "--port", "can://hand?interface=virtual", name, *given)
        heard = [rx.data for rx in bus.receive(0.0)]
        bus.close()
        assert heard == [record(frame.identifier, frame.encode(frame.decode(raw)))]
        return
    with silent_board() as (master, device):
        ran = run("send", "--port", f"serial://{device}", name, *given)
        assert ran.exit_code == 0, ran.stderr
        assert read_now(master) == raw


@pytest.mark.parametrize("content", ["40445524", "40e5", "00"])
def test_hexadecimal_that_looks_like_a_number_is_sent_as_it_is_typed(content: str) -> None:
    with silent_board() as (master, device):
        words = ("auv.MODEM", "address=1", f"content={content}")
        ran = run("send", "--port", f"serial://{device}", *words)
        assert ran.exit_code == 0, ran.stderr
        assert read_now(master)[5:-2].hex() == content


def test_a_frame_is_said_again_for_a_board_that_goes_neutral_without() -> None:
    with silent_board() as (master, device):
        run("send", "--port", f"serial://{device}", "MM", "dir=F", "speed=5", "--for", "1")
        assert 2 <= read_now(master).count(b"@MMF5$") <= 11


def test_a_port_that_a_serve_has_takes_no_raw_frame(tmp_path: Path) -> None:
    config = tmp_path / "serve.yaml"
    config.write_text(f"folder: {tmp_path / 'pi'}\n")
    with silent_board() as (master, device), running(tmp_path / "pi", f"serial://{device}"):
        soon(lambda: (tmp_path / "pi" / "status.json").exists(), "its health")
        for words, why in ((("-c", str(config)), "stop serve"), ((), "in use")):
            ran = run("send", "--port", f"serial://{device}", "--text", "@MMF5$", *words)
            assert ran.exit_code == 1
            assert why in ran.stderr
        assert b"@MMF5$" not in read_now(master)
