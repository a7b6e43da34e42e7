"""What doctor advises fits the vehicle that is there: all four documents, over their own bytes."""

from __future__ import annotations

import json
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from served import PATIENCE, read_now, running, silent_board, simulated, soon

from links import open_link
from links.simulated.boards import BOARDS as SIMULATED
from links.simulated.boards import SimulatedBoard
from links.simulated.pty import PtyVehicle
from mission.commands.doctor import doctor
from mission.model import buoyancy
from mission.model.shipped import load_vehicle
from mission.onboard.doctor import port_probe, signs
from mission.onboard.doctor.boards import BOARDS, board
from mission.onboard.doctor.findings import Condition
from mission.onboard.serve import health
from protocol.tolerances import Tolerances
from protocol.vehicles import VEHICLES
from protocol.vehicles import link as protocol_link

FOREIGN = ("STM32", "@SD", "@R", "shakedown", "float-test", "drop weight")  # of document 000 alone


@contextmanager
def simulated_board(name: str) -> Iterator[str]:
    with PtyVehicle(SimulatedBoard(name, 1), 1.0) as served:
        over = threading.Event()
        thread = threading.Thread(target=served.run, kwargs={"stop": over.is_set})
        thread.start()
        try:
            yield served.paths[0]
        finally:
            over.set()
            thread.join(PATIENCE)


def examined(folder: Path, vehicle: str, device: str) -> list[dict[str, Any]]:
    config = folder / "serve.yaml"
    links = {"vehicle": f"serial://{device}", "gps": None, "topside": "tcp://127.0.0.1:0"}
    config.write_text(f"vehicle: {vehicle}\nfolder: {folder / 'pi'}\nlinks: {json.dumps(links)}\n")
    ran = CliRunner().invoke(doctor, ["-c", str(config), "--json"])
    found: list[dict[str, Any]] = json.loads(ran.stdout)["findings"]
    return found


def of(found: list[dict[str, Any]], what: str) -> dict[str, Any]:
    return next(one for one in found if one["what"] == what)


def test_every_vehicle_of_the_registry_has_a_board_that_doctor_knows() -> None:
    assert set(BOARDS) == {row.name for row in VEHICLES.values()}


@pytest.mark.parametrize("name", sorted(SIMULATED))
def test_a_vehicle_that_reports_is_examined_in_its_own_words(tmp_path: Path, name: str) -> None:
    with simulated_board(name) as device:
        found = examined(tmp_path, name, device)
    assert of(found, "vehicle")["state"] == "ok"
    told = [f"{one['says']} {one['todo']}" for one in found]
    words = FOREIGN if name != "coreboard" else FOREIGN[:-1]
    assert not [text for text in told for word in words if word in text]
    its = BOARDS[name]
    assert any(f"{its.name} goes neutral by itself after {its.silence:g} s" in t for t in told)


def test_what_drives_is_told_of_wheels_and_of_nothing_in_the_water(tmp_path: Path) -> None:
    with simulated_board("robot") as device:
        found = examined(tmp_path, "robot", device)
    told = [f"{one['what']} {one['says']} {one['todo']}" for one in found]
    words = ("thruster", "surface", "dive", "limit depth", "descent", "buoyan")
    assert not [text for text in told for word in words if word in text]
    assert any("keeps the wheels as they are" in text for text in told)


def test_with_a_serve_nobody_is_told_to_check_what_the_vehicle_never_reports(
    tmp_path: Path,
) -> None:
    with simulated_board("robot") as device:
        port, folder = f"serial://{device}", tmp_path / "pi"
        with running(folder, port, kind="robot"):
            soon((folder / health.FILE).exists, "the health of serve")
            soon(lambda: '"battery": {"value": 2' in (folder / health.FILE).read_text(), "volts")
            found = examined(tmp_path, "robot", device)
            told = "\n".join(health.as_lines(health.read(folder, time.time()) or {}, time.time()))
    assert not [one for one in found if one["what"].startswith("sensor ")]
    assert of(found, "margin voltage")["says"].endswith("V left, limit 20 V")
    assert "heading          absent, as the vehicle file says" in told
    assert "limit off        leak: robot does not report leak" in told
    assert "MISSING" not in told


@pytest.mark.parametrize(("name", "says"), [("rov", "f_sign: -1"), ("mainboard", "no key for it")])
def test_a_sign_is_turned_by_a_key_where_the_vehicle_file_has_one(name: str, says: str) -> None:
    (down, *_) = signs.probes_of(load_vehicle(name))
    assert says in signs.turned(down, name)


def test_where_the_vehicle_has_two_boards_each_is_told_its_own_frames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("can", reason="python-can is not installed: pip install auvmission[can]")
    vehicle = load_vehicle("mainboard")
    short = tuple(replace(probe, seconds=0.2) for probe in signs.probes_of(vehicle))
    monkeypatch.setattr(signs, "REST_S", 0.2)
    monkeypatch.setattr(signs, "probes_of", lambda _vehicle: short)
    url = f"can://{tmp_path.name}?interface=virtual"
    bus = open_link("board", url)
    with silent_board() as (master, device):
        found = list(signs.sign_findings(f"{url}&sensors={device}", vehicle))
        line = read_now(master)
    told = Counter(rx.data[:3] for rx in bus.receive(0.0))
    bus.close()
    nothing = ["no depth in the reports", "no heading in the reports"]
    assert [one.says for one in found[:2]] == nothing
    assert set(told) == {b"\0\1\7", b"\0\2\7"}, "force and torque"
    assert line.count(b"\xfe\xef") == line.count(b"\xfd\xdf") == told[b"\0\1\7"]


def test_what_its_frames_carry_beside_the_effort_is_what_the_vehicle_file_says_is_safe(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sent: list[bytes] = []

    class Line:
        def fileno(self) -> int:
            return -1

        def send(self, data: bytes, now: float, address: str = "") -> None:
            sent.append(data)

        def receive(self, now: float) -> list[object]:
            return []

        def close(self) -> None:
            pass

    vehicle = load_vehicle("mainboard")
    monkeypatch.setattr(signs, "REST_S", 0.1)
    monkeypatch.setattr(signs, "probes_of", lambda _vehicle: ())
    monkeypatch.setattr(signs, "open_whole", lambda _name, _url: Line())
    assert not list(signs.sign_findings("can://can0?sensors=/dev/none", vehicle))
    frame = protocol_link("coreboard.main_to_sensor").frames(Tolerances())[0]
    told = [frame.decode(data)["ptz"] for data in sent if data[0] > 7]
    assert set(told) == {vehicle.safe_levels["ptz"]}


@pytest.mark.parametrize("word", ["--ask", "--signs"])
def test_nobody_is_asked_about_what_a_vehicle_does_not_do(tmp_path: Path, word: str) -> None:
    """No input is there: a question would end it."""
    config = tmp_path / "serve.yaml"
    links = {"vehicle": "serial:///dev/none", "gps": None, "topside": "tcp://127.0.0.1:0"}
    config.write_text(f"vehicle: robot\nfolder: {tmp_path}\nlinks: {json.dumps(links)}\n")
    ran = CliRunner().invoke(doctor, ["-c", str(config), word, "--json"])
    said = json.loads(ran.stdout)["findings"]
    assert any(one["says"].startswith(("not asked", "not tried")) for one in said)


@pytest.mark.parametrize("name", sorted(SIMULATED))
def test_a_board_that_is_silent_is_told_by_its_name_and_sent_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setattr(port_probe, "LISTEN_S", 0.3)
    with silent_board() as (master, device):
        found = examined(tmp_path, name, device)
        assert read_now(master) == b""
    one = of(found, "vehicle")
    assert one["state"] == "fault"
    assert f"restart {BOARDS[name].name}" in one["todo"]


def test_the_auv_behind_another_vehicles_file_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(port_probe, "LISTEN_S", 2.0)
    with simulated(4.0) as sea:
        found = examined(tmp_path, "rov", sea.paths[0])
    assert "this is the AUV's STM32" in of(found, "vehicle")["says"]
    assert "vehicle:" in of(found, "vehicle")["todo"]


def test_the_auv_is_still_told_of_its_last_setpoint_and_its_own_words(tmp_path: Path) -> None:
    with simulated(4.0) as sea:
        found = examined(tmp_path, "auv", sea.paths[0])
    assert "keeps its last setpoint" in of(found, "assumed")["says"]
    assert "the STM32 answers @RI" in of(found, "vehicle answers")["says"]


def test_a_sensor_without_a_word_is_advised_what_its_board_has() -> None:
    for name, says in (("auv", "auvmission power"), ("coreboard", "byte 43")):
        vehicle = load_vehicle(name)
        (one, *_) = [
            one
            for one in port_probe.of_vehicle(vehicle, [port_probe.Telemetry(0.0)])
            if one.condition is Condition.FAULT and one.what.startswith("sensor")
        ]
        assert says in one.todo
        assert board(vehicle) is BOARDS[name]


def test_what_reports_nothing_by_its_document_is_no_fault() -> None:
    from dataclasses import replace

    vehicle = replace(load_vehicle("coreboard"), codec="motorcan", reports=frozenset())
    (one,) = port_probe.of_vehicle(vehicle, [])
    assert one.condition is Condition.OK


def test_the_rise_is_measured_as_the_vehicle_can() -> None:
    today = date(2026, 1, 1)
    assert "float-test" in buoyancy.doubt(load_vehicle("auv"), today)
    by_hand = buoyancy.doubt(load_vehicle("rov"), today)
    assert "float-test" not in by_hand
    assert "time its rise" in by_hand
