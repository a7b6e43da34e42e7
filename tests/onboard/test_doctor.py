"""Every line is something a person can act on; a serve that runs is not disturbed."""

from __future__ import annotations

import errno
import json
import os
import shutil
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from served import running, silent_board, simulated, soon

from links.serial import SerialLink
from mission.commands.doctor import doctor
from mission.commands.operator import status
from mission.engine.restart import UNSEEN
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration, LinkUrls
from mission.onboard.doctor import doctor as rows
from mission.onboard.doctor import port_probe
from mission.onboard.doctor.findings import Condition, Finding
from mission.onboard.kept import default_folder
from mission.onboard.serve import health
from mission.onboard.serve.instance_lock import only_one
from mission.onboard.serve.keys import make_keys
from mission.onboard.store import DiskStore
from protocol.messages import Telemetry
from protocol.nmea import NmeaDecoder


def examined(folder: Path, text: str = "", vehicle: str = "", gps: str = "null") -> dict[str, Any]:
    config = folder / "serve.yaml"
    config.write_text(
        f"folder: {folder / 'pi'}\n{text}\n"
        + (f"links: {{vehicle: '{vehicle}', gps: {gps}}}\n" if vehicle else "")
    )
    ran = CliRunner().invoke(doctor, ["-c", str(config), "--json"])
    found: dict[str, Any] = json.loads(ran.stdout)
    assert ran.exit_code == (0 if found["ok"] else 1)
    for one in found["findings"]:
        assert one["state"] in ("ok", "warning", "fault")
        assert one["what"]
        assert one["says"]
        assert one["todo"] or one["state"] == "ok", "says what to do"
    return found


def of(found: Mapping[str, Any], what: str) -> Mapping[str, Any]:
    (one,) = [one for one in found["findings"] if one["what"] == what]
    return dict(one)


def test_a_healthy_vehicle_has_no_fault(tmp_path: Path) -> None:
    with simulated(4.0) as sea:
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        found = examined(tmp_path, vehicle=stm32, gps=f"'{gps}'")
    assert found["ok"]
    for what in ("vehicle", "vehicle answers", "sensor depth", "sensor heading", "GPS"):
        assert of(found, what)["state"] == "ok", what
    assert "alive" in of(found, "sensor heading")["says"]
    assert sum(one["what"] == "assumed" for one in found["findings"]) >= 2


def test_a_board_that_is_silent_is_a_fault_with_its_cables(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(port_probe, "LISTEN_S", 0.3)
    monkeypatch.setattr(port_probe, "GPS_S", 0.3)
    with silent_board() as (_, device), silent_board() as (master, gps):
        over = threading.Event()

        def receiver() -> None:
            while not over.wait(0.05):
                os.write(master, b"$GPGGA,,,,,,0,00,,,,,,,*66\r\n")

        thread = threading.Thread(target=receiver)
        thread.start()
        try:
            found = examined(tmp_path, vehicle=f"serial://{device}", gps=f"'serial://{gps}'")
        finally:
            over.set()
            thread.join()
    assert of(found, "vehicle")["state"] == "fault"
    assert "cable" in of(found, "vehicle")["todo"]
    assert of(found, "vehicle answers")["state"] == "fault"
    assert of(found, "GPS")["state"] == "warning"
    assert "antenna" in of(found, "GPS")["todo"]


def test_ports_that_are_absent_or_taken_say_which_and_what_to_do(tmp_path: Path) -> None:
    found = examined(tmp_path, vehicle="serial:///dev/ttyNOSUCH", gps="null")
    assert "no device /dev/ttyNOSUCH" in of(found, "vehicle port")["says"]
    with silent_board() as (_, device):
        other = SerialLink("other", device)
        found = examined(tmp_path, vehicle=f"serial://{device}")
        other.close()
    assert "fuser" in of(found, "vehicle port")["todo"]


def test_a_serve_that_runs_is_not_disturbed_and_its_health_is_judged(tmp_path: Path) -> None:
    with simulated(4.0) as sea:
        stm32, gps = (f"serial://{path}" for path in sea.paths)
        with running(tmp_path / "pi", stm32, gps=gps, speed=4.0) as pi:
            file = tmp_path / "pi" / health.FILE

            def reports() -> bool:
                return file.exists() and '"depth": {"value": 0' in file.read_text()

            soon(reports, "a depth in the health")
            found = examined(tmp_path, vehicle=stm32, gps=f"'{gps}'")
            assert "its ports are left alone" in of(found, "serve")["says"]
            assert of(found, "link vehicle")["state"] == "ok"
            assert of(found, "margin depth")["state"] == "ok"
            assert not pi.has_told("vehicle:")
            ran = CliRunner().invoke(status, ["--local", "-c", str(tmp_path / "serve.yaml")])
            assert ran.exit_code == 0
            assert "to radius" in ran.stdout
            raw = CliRunner().invoke(
                status, ["--local", "--json", "-c", str(tmp_path / "serve.yaml")]
            )
            assert json.loads(raw.stdout)["margins"]["depth"]["bound"] == 100.0


def test_a_dead_or_silent_serve_is_not_taken_for_one_that_runs(tmp_path: Path) -> None:
    assert health.read(tmp_path, time.time()) is None
    file = tmp_path / health.FILE
    file.write_text(json.dumps({"pid": os.getpid(), "wall": time.time()}))
    assert health.read(tmp_path, time.time()) is not None
    assert health.read(tmp_path, time.time() + 2 * health.STALE_S) is None
    for text in ("", "{", "[]", '{"pid": "x"}', f'{{"pid": 4194999, "wall": {time.time()}}}'):
        file.write_text(text)
        assert health.read(tmp_path, time.time()) is None
    config = tmp_path / "serve.yaml"
    config.write_text(f"folder: {tmp_path}\n")
    ran = CliRunner().invoke(status, ["--local", "-c", str(config)])
    assert ran.exit_code == 1
    assert "no serve is running" in ran.output


def test_a_wrong_configuration_is_a_fault_with_its_keys(tmp_path: Path) -> None:
    found = examined(tmp_path, "vehicel: auv")
    assert "vehicel" in of(found, "configuration")["says"]
    found = examined(tmp_path, "vehicle: boat")
    assert "shipped ones" in of(found, "configuration")["says"]


def test_a_configuration_that_is_not_there_is_to_be_given_and_not_mended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    (default_folder() / "store").mkdir(parents=True)  # an empty one: nothing is under way
    ran = CliRunner().invoke(doctor, ["-c", str(tmp_path / "none.yaml"), "--json"])
    found = of(json.loads(ran.stdout), "configuration")
    assert ran.exit_code == 1
    assert "none.yaml: cannot be read" in found["says"]
    assert found["todo"].startswith("give the file")


def judged(folder: Path, check: str, **more: object) -> list[Finding]:
    configuration = Configuration(folder=folder, **more)  # type: ignore[arg-type]
    context = rows.CheckContext(configuration, load_vehicle("auv"), None)
    return list(getattr(rows, check)(context))


def test_a_folder_that_cannot_be_written_and_a_disk_that_is_full_are_faults(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    (one,) = judged(tmp_path / "file", "_disk")
    assert one.condition is Condition.FAULT
    usage = type("Usage", (), {"free": 1 << 20})
    monkeypatch.setattr(rows.shutil, "disk_usage", lambda _: usage)
    assert judged(tmp_path, "_disk")[-1].condition is Condition.FAULT
    usage.free = 1 << 30
    assert judged(tmp_path, "_disk")[-1].condition is Condition.WARNING


def test_what_was_under_way_and_what_is_damaged_are_told(tmp_path: Path) -> None:
    store = DiskStore(tmp_path / "store")
    store.keep_under_way("autonomous/out")
    (tmp_path / "store" / "mission").write_text("rubbish")
    says = [one.says for one in judged(tmp_path, "_store")]
    assert any("damaged" in text for text in says)
    assert any("autonomous/out was under way" in text for text in says)
    store.keep_under_way(UNSEEN)
    (todo,) = [one.todo for one in judged(tmp_path, "_store") if UNSEEN in one.says]
    assert "serve will stop the vehicle" in todo


def test_an_open_topside_is_a_warning_and_missing_keys_a_fault(tmp_path: Path) -> None:
    (one,) = judged(tmp_path, "_topside", links=LinkUrls(topside="tcp://0.0.0.0:0"))
    assert one.condition is Condition.WARNING
    url = f"tls://0.0.0.0:0?keys={tmp_path}"
    (one,) = judged(tmp_path, "_topside", links=LinkUrls(topside=url))
    assert one.condition is Condition.FAULT
    assert "auvmission keys" in one.todo


def test_what_stands_at_the_port_instead_of_the_vehicle_is_named() -> None:
    auv = load_vehicle("auv")
    sentence = b"$GPGGA,,,,,,0,00,,,,,,,*66\r\n"
    for raw, says, todo in (
        (sentence * 3, "GPS receiver", "swap links.vehicle and links.gps"),
        (port_probe.QUERY, "comes back", "TX and RX are joined"),
        (b"", "0 bytes", "power"),
        (bytes(range(200)), "200 bytes", "power"),
    ):
        one = next(iter(port_probe.of_vehicle(auv, [], raw)))
        assert one.condition is Condition.FAULT
        assert says in one.says
        assert todo in one.todo
    one = port_probe.of_gps(NmeaDecoder(), [], b"xx@SD\x00\x01")
    assert "this is the STM32" in one.says
    assert "swap" in one.todo


def test_a_serve_that_hangs_or_whose_disk_is_full_is_told_from_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "pi"
    folder.mkdir()
    old = time.time() - 2 * health.STALE_S
    (folder / health.FILE).write_text(json.dumps({"pid": os.getpid(), "wall": old}))
    assert health.mute(folder, time.time()) is None, "the number is another program's by now"
    monkeypatch.setattr(health, "_serves", lambda pid: True)
    found = examined(tmp_path, vehicle="serial:///dev/ttyNOSUCH", gps="null")
    assert of(found, "serve")["state"] == "fault"
    assert "free the disk" in of(found, "serve")["todo"]
    assert not any(one["what"] == "vehicle port" for one in found["findings"]), "it has the port"


def test_a_serve_of_which_the_disk_never_took_a_word_is_known_by_its_lock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Read-only from the start on: its ports are left alone all the same."""
    folder = tmp_path / "pi"
    folder.mkdir()
    monkeypatch.setattr(health, "_serves", lambda pid: pid == os.getpid())
    with only_one(folder):
        assert health.mute(folder, time.time()) == os.getpid()
        found = examined(tmp_path, vehicle="serial:///dev/ttyNOSUCH", gps="null")
    assert "read-only" in of(found, "serve")["todo"]
    assert not any(one["what"] == "vehicle port" for one in found["findings"]), "it has the port"
    assert health.mute(folder, time.time()) is None


@pytest.mark.parametrize(
    ("number", "todo"),
    [(errno.ENOSPC, "move old black boxes"), (errno.EROFS, "SD card"), (errno.EACCES, "chown")],
)
def test_a_folder_that_takes_nothing_has_the_remedy_of_its_cause(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, todo: str
) -> None:
    def refuse(**_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(rows.tempfile, "NamedTemporaryFile", refuse)
    (one,) = judged(tmp_path, "_disk")
    assert os.strerror(number) in one.says
    assert todo in one.todo


@pytest.mark.parametrize(
    ("links", "what", "says"),
    [
        ({"topside": "foo"}, "topside", "is no link's URL"),
        ({"topside": "tcp://127.0.0.1"}, "topside", "write tcp-listen://host:port"),
        ({"topside": "tcp://127.0.0.1:0?allow=boat"}, "topside", "neither an address"),
        ({"topside": "tls://127.0.0.1:0?keyz=1"}, "topside", "unknown option 'keyz'"),
        ({"vehicle": "memory://alone"}, "vehicle", "0 bytes"),
        ({"vehicle": "serial:///dev/null"}, "vehicle port", "is no serial port"),
        ({"gps": "serial:///dev/x?baud=abc"}, "GPS port", "baud=abc"),
        ({"modem": "serail:///dev/x"}, "modem port", "is no link's URL"),
        ({"modem": "serial:///dev/ttyNOSUCH"}, "modem port", "no device"),
        ({"sensors": "serial:///dev/ttyNOSUCH"}, "sensors port", "no device"),
        ({"gps2": "serial:///dev/ttyNOSUCH"}, "gps2 port", "no device"),
    ],
)
def test_every_link_that_cannot_be_used_is_a_fault_and_never_a_crash(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, links: dict[str, str], what: str, says: str
) -> None:
    monkeypatch.setattr(port_probe, "LISTEN_S", 0.2)
    config = tmp_path / "serve.yaml"
    ours = {"vehicle": "serial:///dev/ttyNOSUCH", "topside": "tcp://127.0.0.1:0", "gps": None}
    config.write_text(f"folder: {tmp_path / 'pi'}\nlinks: {json.dumps(ours | links)}\n")
    ran = CliRunner().invoke(doctor, ["-c", str(config), "--json"])
    one = of(json.loads(ran.stdout), what)
    assert one["state"] == "fault"
    assert says in one["says"]
    assert one["todo"]


@pytest.mark.parametrize(
    ("said", "state", "says"),
    [
        (b":BS,  +12, +812,   -3,A\r\n", "ok", "speed over ground"),
        (b":BS,-32768,-32768,-32768,V\r\n", "warning", "no value"),
        (b"\x00\xff\x81 noise\r\n", "fault", "no line"),
        (b"", "fault", "0 bytes"),
    ],
)
def test_the_line_of_added_sensors_is_listened_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: bytes, state: str, says: str
) -> None:
    monkeypatch.setattr(port_probe, "LISTEN_S", 0.1)
    monkeypatch.setattr(port_probe, "SENSORS_S", 0.4)
    config = tmp_path / "serve.yaml"
    over = threading.Event()
    with silent_board() as (master, device):

        def sensor() -> None:
            while said and not over.wait(0.05):
                os.write(master, said)

        thread = threading.Thread(target=sensor)
        thread.start()
        links = {"vehicle": "serial:///dev/ttyNOSUCH", "gps": None, "sensors": f"serial://{device}"}
        config.write_text(f"folder: {tmp_path / 'pi'}\nlinks: {json.dumps(links)}\n")
        ran = CliRunner().invoke(doctor, ["-c", str(config), "--json"])
        over.set()
        thread.join()
    found = json.loads(ran.stdout)
    assert of(found, "sensors port")["state"] == "ok"
    one = of(found, "added sensors")
    assert one["state"] == state
    assert says in one["says"]


@pytest.mark.parametrize(
    ("command", "condition"),
    [
        ("sh -c true", Condition.OK),
        ("nosuchprogram -x", Condition.FAULT),
        ("sh 'unclosed", Condition.FAULT),
    ],
)
def test_a_camera_that_cannot_be_run_is_a_fault(
    tmp_path: Path, command: str, condition: Condition
) -> None:
    (one,) = judged(tmp_path, "_camera", camera=command)
    assert one.condition is condition


@pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes the keys")
def test_a_key_that_others_can_read_is_told(tmp_path: Path) -> None:
    make_keys(tmp_path / "k", [], lambda _: None)
    url = f"tls://127.0.0.1:0?keys={tmp_path}/k/vehicle"
    (one,) = judged(tmp_path, "_topside", links=LinkUrls(topside=url))
    assert one.condition is Condition.OK
    (tmp_path / "k" / "vehicle" / "key.pem").chmod(0o644)
    (one,) = judged(tmp_path, "_topside", links=LinkUrls(topside=url))
    assert one.condition is Condition.WARNING
    assert "chmod 600" in one.todo


def test_a_frozen_sensor_is_told_from_a_living_one() -> None:
    auv = load_vehicle("auv")
    heard = [Telemetry(float(i), depth=0.1, altitude=2.0 + i, heading=1.0) for i in range(3)]
    found = {one.what: one for one in port_probe.of_vehicle(auv, heard)}
    assert "to the last bit" in found["sensor depth"].says
    assert found["sensor depth"].condition is Condition.WARNING
    assert found["sensor altitude"].condition is Condition.OK
    assert found["sensor roll"].condition is Condition.FAULT, "it is declared, and silent"
    upside = [Telemetry(0.0, depth=3.0, roll=3.0)]
    found = {one.what: one for one in port_probe.of_vehicle(auv, upside)}
    assert found["sensor depth"].condition is Condition.WARNING
    assert found["sensor roll"].condition is Condition.WARNING


def test_what_never_came_has_no_age() -> None:
    """A board's report is of now where a value in it is missing."""
    missing = {"value": None, "unit": "m", "age_s": 0.1, "why": "missing"}
    assert health.sensed(missing) == "MISSING"
    stale = {"value": 3.0, "unit": "m", "age_s": 9.1, "why": "stale"}
    assert health.sensed(stale) == "STALE, 9 s old: last 3.00 m"


@pytest.mark.parametrize(("value", "shown"), [(0.0, "no, 0 s ago"), (1.0, "yes, 0 s ago")])
def test_a_leak_is_there_or_not(value: float, shown: str) -> None:
    assert health.sensed({"value": value, "unit": "", "age_s": 0.4, "why": ""}) == shown
