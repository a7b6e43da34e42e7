"""A board that speaks the other dialect: asked on deck, and told when it refuses a leg's set."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from served import read_now, running, silent_board, simulated, soon

from links.base import Rx
from links.simulated.link import SimulatedVehicle
from links.simulated.pty import PtyVehicle
from links.simulated.settings import Settings
from mission.authoring.language import parse, script
from mission.commands.doctor import doctor
from mission.model import Tx
from mission.model.shipped import load_vehicle, missions_folder
from mission.model.vehicle import Vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.doctor.asking import dialect_finding
from mission.onboard.runtime.records import Nobody
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.serve import health
from mission.onboard.store import MemoryStore, Stored
from mission.verification.simulation.flight import fly
from protocol.messages import Ack, Order, Setpoint
from protocol.vehicles import codec
from protocol.vehicles.auv import MEANINGS, dialect_of

TEXT = """\
mission pool vehicle auv
safety radius 200 time 5min depth 5
start without fix
a: depth 2 heading 0 gear 4 for 20
"""
LEAN = TEXT + "b: depth 2 heading 0 gear 4 pitch 5 for 5\n"
FILES = {"as-built": "auv", "documented": "auv-documented"}


class Journal(Nobody):
    def __init__(self) -> None:
        self.notices: list[str] = []

    def notice(self, text: str) -> None:
        self.notices.append(text)


class Pool:
    """A runtime that was told of one dialect, and a board that was built to another."""

    def __init__(self, vehicle: Vehicle, built: str, text: str) -> None:
        self.journal, self.sent, self.now = Journal(), list[Tx](), 0.0
        lines = tuple(script(parse(text)))
        self.sea = SimulatedVehicle(built, 1, Settings(splice=0.0))
        store = MemoryStore(Stored(lines))
        self.runtime = Runtime(Configuration(), vehicle, store, observer=self.journal)
        self._leave(self.runtime.set_navigation(self.runtime.make_navigation(), 0.0))

    def say(self, word: bytes) -> list[bytes]:
        before = len(self.sent)
        self._leave(self.runtime.receive(Rx(self.now, "topside", word, "boat")))
        return [tx.data for tx in self.sent[before:] if tx.link == "topside"]

    def until(self, end: float) -> None:
        link = self.sea.vehicle_link
        while True:
            events = (link.next_event(), self.runtime.next_timer())
            due = max(self.now, min(t for t in events if t is not None))
            if due > end:
                break
            self.now = due
            for rx in link.receive(due):
                self._leave(self.runtime.receive(rx, due))
            timer = self.runtime.next_timer()
            if timer is not None and timer <= due:
                self._leave(self.runtime.handle_timer(due))
        self.now = end

    def _leave(self, sent: list[Tx]) -> None:
        self.sent += sent
        for tx in sent:
            if tx.link == "vehicle":
                self.sea.vehicle_link.send(tx.data, self.now)


def started(vehicle: str, built: str, text: str = TEXT) -> Pool:
    pool = Pool(load_vehicle(vehicle), built, text)
    pool.until(5.0)
    assert pool.say(b"@AA$") == [b"@ACK_AAA$"]
    return pool


def test_a_heading_refused_by_a_board_built_to_the_letter_is_told_with_what_to_do() -> None:
    pool = started("auv", "documented")
    pool.until(10.0)
    words = "the vehicle refused @ZAH0,4$: probably built to the letter, where no gear stands"
    (notice,) = pool.journal.notices
    assert notice.startswith(words)
    assert notice.endswith("the vehicle file is auv-documented")
    (report,) = pool.say(b"@AQ$")
    assert b"ZA: the vehicle refused ZAH0;4: probably built to the letter" in report
    assert b"auv-documented" in report
    assert pool.runtime.state == "autonomous/surface"  # as ever: a refused set takes the else


def test_an_attitude_refused_as_built_is_told_with_what_to_do() -> None:
    pool = started("auv-documented", "as-built", LEAN)
    pool.until(40.0)
    assert [n for n in pool.journal.notices if "ZAA5;0" in n and n.endswith("file is auv")]


@pytest.mark.parametrize("dialect", FILES)
def test_each_dialect_is_shipped_and_its_file_flies_the_board_it_is_for(dialect: str) -> None:
    vehicle = load_vehicle(FILES[dialect])
    assert vehicle.dialect == dialect
    flight = fly(parse(TEXT), vehicle, seed=2)
    assert flight.outcome == "completed", flight.reason
    pool = started(FILES[dialect], dialect)
    pool.until(20.0)
    assert pool.journal.notices == []


def test_the_two_shipped_files_differ_in_what_the_dialects_differ_in_alone() -> None:
    one, other = load_vehicle("auv"), load_vehicle("auv-documented")
    assert other.follows == one.follows | {"attitude"}
    alike = replace(
        other,
        name=one.name,
        dialect=one.dialect,
        follows=one.follows,
        one_speed=one.one_speed,
        constant_batteries=one.constant_batteries,
    )
    assert alike == one
    assert (missions_folder() / "vehicles" / "auv-documented.yaml").is_file()


@pytest.mark.parametrize(("dialect", "code"), MEANINGS)
def test_a_meaning_names_a_shipped_file_that_does_not_say_that_word(
    dialect: str, code: bytes
) -> None:
    board, asked = codec("auv", dialect, {}), {b"H": Setpoint(surge=0.5, heading=0.0)}
    setpoint = asked.get(code, Setpoint(depth=2.0, heading=0.0, pitch=0.1))
    frame = next(f for f in board.encode(setpoint) if f[3:4] == code)
    meaning = board.meaning_of_no(frame)
    other = next(d for d in FILES if d != dialect)
    assert meaning.endswith(f"the vehicle file is {FILES[other]}")
    assert board.meaning_of_no(b"@ZAS30$") == ""
    assert board.meaning_of_no(b"@RI$") == ""


@pytest.mark.parametrize("built", FILES)
def test_the_answer_to_a_stop_tells_the_build(built: str) -> None:
    vehicle = SimulatedVehicle(built, 1, Settings(splice=0.0))
    board = codec("auv", "as-built", {})
    vehicle.vehicle_link.send(board.encode(Order.STOP)[0], 0.0)
    heard = [m for rx in vehicle.vehicle_link.receive(1.0) for m in board.receive(rx.data, rx.t)]
    assert [dialect_of(one) for one in heard if isinstance(one, Ack)] == [built]
    assert dialect_of(Ack(0.0, "R", "A", ord("Y"))) == ""


# --- doctor --ask ---------------------------------------------------------------------------------


@contextmanager
def board(built: str) -> Iterator[PtyVehicle]:
    vehicle = PtyVehicle(SimulatedVehicle(built, 0, Settings(splice=0.0)), 4.0)
    over = threading.Event()
    thread = threading.Thread(target=vehicle.run, kwargs={"stop": over.is_set})
    thread.start()
    try:
        yield vehicle
    finally:
        over.set()
        thread.join(10.0)
        vehicle.close()


def examined(folder: Path, vehicle: str, port: str, *options: str, says: str = "") -> Any:
    config = folder / "serve.yaml"
    config.write_text(
        f"vehicle: {vehicle}\nfolder: {folder / 'pi'}\nlinks: {{vehicle: '{port}', gps: null}}\n"
    )
    return CliRunner().invoke(doctor, ["-c", str(config), "--json", *options], input=says)


def dialect(ran: Any) -> dict[str, str]:
    text = ran.stdout[ran.stdout.index("{") :]
    (one,) = [one for one in json.loads(text)["findings"] if one["what"] == "dialect"]
    return dict(one)


@pytest.mark.parametrize("built", FILES)
@pytest.mark.parametrize("told", FILES)
def test_doctor_asks_which_dialect_a_board_speaks(built: str, told: str, tmp_path: Path) -> None:
    with board(built) as sea:
        ran = examined(tmp_path, FILES[told], f"serial://{sea.paths[0]}", "--ask", "--on-deck")
    found = dialect(ran)
    assert f"the board speaks {built}" in found["says"]
    assert found["state"] == ("ok" if built == told else "fault")
    assert (f"vehicle: {FILES[built]}" in found["todo"]) == (built != told)


def test_unless_it_is_asked_to_and_told_that_it_is_on_deck_doctor_sends_no_stop(
    tmp_path: Path,
) -> None:
    with silent_board() as (master, device):
        plain = examined(tmp_path, "auv", f"serial://{device}")
        refused = examined(tmp_path, "auv", f"serial://{device}", "--ask", says="n\n")
        assert read_now(master) == b"@RI$"
    assert '"dialect"' not in plain.stdout
    assert refused.exit_code == 1
    assert "findings" not in refused.stdout


def test_a_board_that_does_not_answer_is_told_as_that(tmp_path: Path) -> None:
    with silent_board() as (master, device):
        found = dialect_finding(f"serial://{device}", load_vehicle("auv"))
        assert read_now(master) == 3 * b"@ZAX0$"
    assert found.says == "no answer to @ZAX0$ in 3 tries"
    assert "TX line" in found.todo


def test_doctor_asks_nothing_where_a_serve_has_the_port(tmp_path: Path) -> None:
    with simulated(4.0) as sea:
        port = f"serial://{sea.paths[0]}"
        with running(tmp_path / "pi", port, speed=4.0):
            soon((tmp_path / "pi" / health.FILE).exists, "the health of serve")
            ran = examined(tmp_path, "auv", port, "--ask")  # and nobody, where it lies
    assert "a serve has the vehicle's port" in dialect(ran)["says"]


@pytest.mark.parametrize("name", ["rov", "coreboard", "robot"])
def test_a_board_that_answers_nothing_is_not_asked(name: str) -> None:
    found = dialect_finding("serial:///dev/none", load_vehicle(name))
    assert found.says.startswith("not asked")
