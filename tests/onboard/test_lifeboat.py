"""The last way up: with the standard library alone, and only where something may be under way."""

from __future__ import annotations

import json
import os
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

import pytest
from served import PATIENCE, read_now, silent_board, simulated, soon

from mission.engine.restart import STOPS
from mission.model import UNKNOWN
from mission.model.shipped import load_vehicle, vehicle_file
from mission.model.vehicle_file import read_vehicle
from mission.onboard.configuration import Configuration, LinkUrls
from mission.onboard.kept import Homes, write_summed
from mission.onboard.lifeboat import (
    Climb,
    Plan,
    can_frame,
    depths,
    launch,
    opened,
    plan_from,
)
from mission.onboard.serve.working import Working, keep
from mission.onboard.store import DiskStore
from protocol.tolerances import Tolerances
from protocol.vehicles import link

X, W, U = b"@ZAX0$", b"@ZAWF$", b"@ZAU12$"


def said(climb: Climb, seconds: float, depth: float | None, now: float) -> list[tuple[bytes, ...]]:
    """What it says in that time, with a report each 2 s; once each."""
    out: list[tuple[bytes, ...]] = []
    end, reported = now + seconds, now
    while now < end:
        if depth is not None and now >= reported:
            climb.hear(depth, now)
            reported += 2.0
        words = climb.words(now)
        if words and out[-1:] != [words]:
            out.append(words)
        now += 0.1
    return out


def test_the_ways_up_take_turns_while_the_depth_does_not_fall() -> None:
    for depth in (None, 5.0):
        assert said(Climb(Plan(), 0.0), 39.0, depth, 0.0) == [(X, U), (X,), (W,), (X, U)]


def test_what_makes_the_depth_fall_is_kept_and_ends_at_the_surface_with_a_stop() -> None:
    climb, now, depth = Climb(Plan(), 0.0), 0.0, 6.0
    out = []
    for _ in range(40):
        out += said(climb, 2.0, depth, now)
        now, depth = now + 2.0, max(0.1, depth - 0.2)
    assert out[0] == (X, U)
    assert set(out) == {(X, U), (X,)}
    assert out[-1] == (X,)
    assert climb.last_words == ()


def test_six_seconds_of_shallow_depth_are_the_surface_and_five_are_not() -> None:
    climb = Climb(Plan(), -1.0)
    climb.hear(0.6, -1.0)
    for t in (0.0, 2.0, 4.0, 5.9):
        climb.hear(0.2, t)
    assert climb.words(5.9) == (X, U)
    climb.hear(0.2, 6.0)
    assert climb.words(6.0) == (X,)


@pytest.mark.parametrize(("offset", "up"), [(-0.9, False), (-0.7, True)])
def test_a_depth_far_above_the_water_is_no_surface(offset: float, up: bool) -> None:
    climb = Climb(Plan(), -1.0)
    for i in range(8):
        climb.hear(offset + 0.01 * i, float(i))
    assert (climb.words(8.0) == (X,)) is up


def test_for_the_last_way_up_a_depth_that_never_changes_is_no_surface() -> None:
    """Nobody saw it before: it may have got stuck there."""
    climb = Climb(Plan(), 0.0)
    assert said(climb, 39.0, 0.2, 0.0) == [(X, U), (X,), (W,), (X, U)]
    for t in (40.0, 42.0, 44.0, 46.0):
        climb.hear(0.21, t)
    assert climb.words(46.0) == (X,)


def test_for_the_last_way_up_what_was_shallow_before_a_silence_is_no_surface() -> None:
    climb = Climb(Plan(), 0.0)
    for t, depth in ((0.0, 0.6), (2.0, 0.2), (8.1, 0.2)):
        climb.hear(depth, t)
    assert climb.words(8.1) == (X, U)
    for t in (10.1, 12.1, 14.1):
        climb.hear(0.2, t)
    assert climb.words(14.1) == (X,)


def test_a_second_climb_proves_the_surface_anew() -> None:
    """One shallow report behind the deep ones is none, whatever the first climb ended with."""
    climb = Climb(Plan(), 0.0)
    for t, depth in enumerate((0.6, 0.2, 0.2, 0.2, 0.2, 2.1, 2.1, 2.1, 0.3)):
        climb.hear(depth, 2.0 * t)
    assert climb.words(16.0) == (X, U)


def test_at_rest_it_stops_and_turns_no_thruster_until_three_reports_say_deep() -> None:
    climb = Climb(Plan(climbs=False), 0.0)
    assert said(climb, 20.0, None, 0.0) == [(X,)]
    assert said(climb, 20.0, 2.0, 20.0) == []
    climb.hear(2.1, 41.0)
    climb.hear(2.1, 43.0)
    assert climb.words(43.0) == ()
    climb.hear(2.1, 45.0)
    assert climb.words(45.0) == (X, U)


def test_a_word_is_said_three_times_and_where_a_board_wants_it_for_ever() -> None:
    for period, count in ((None, 3), (0.125, 50)):
        climb = Climb(Plan(climbs=False, period=period), 0.0)
        assert sum(bool(climb.words(0.125 * i)) for i in range(50)) == count


def report(depth: float) -> bytes:
    frame = bytearray(b"@SD" + bytes(82) + b"$")
    struct.pack_into("<f", frame, 19, depth)
    return bytes(frame)


def test_depths_come_from_whole_reports_alone() -> None:
    good = report(4.5)
    spliced = good[:30] + b"@ACK_ZAY$" + good[30:]
    buffer = bytearray(b"@ACK_ZAY$" + good + b"xx@S" + report(float("nan")) + spliced + good[:50])
    assert list(depths(buffer)) == [4.5]
    buffer += good[50:] + good
    assert list(depths(buffer)) == [4.5, 4.5]
    buffer += bytes(100_000)
    assert list(depths(buffer)) == []
    assert len(buffer) <= 4096


# --- what it begins with --------------------------------------------------------------------------


def left(
    folder: Path,
    under_way: str,
    vehicle: str = "auv",
    device: str = "/dev/ttyAUV",
    url: str = "",
) -> Path:
    links = LinkUrls(vehicle=url or f"serial://{device}?baud=115200")
    configuration = Configuration(folder=folder / "pi", links=links)
    keep(Working(configuration, load_vehicle(vehicle)), Homes(None, folder / "pi", {}))
    DiskStore(folder / "pi" / "store").keep_under_way(under_way)
    config = folder / "serve.yaml"
    config.write_text(f"folder: {folder / 'pi'}\n")
    return config


def test_its_words_and_port_are_those_of_the_configuration_that_worked(tmp_path: Path) -> None:
    config = left(tmp_path, "autonomous/out")
    plan = plan_from(["--config", str(config)], {})
    url = "serial:///dev/ttyAUV?baud=115200"
    assert plan == Plan(url, 115200, (X,), (W,), (X, U), None, True)
    plan = plan_from([f"--config={config}", "--vehicle", "serial:///dev/other"], {})
    assert plan is not None
    assert (plan.url, plan.baud) == ("serial:///dev/other", 9600)


def test_other_vehicles_are_told_in_their_own_words_and_at_their_pace(tmp_path: Path) -> None:
    plan = plan_from(["-c", str(left(tmp_path, "autonomous/out", "rov"))], {})
    assert plan is not None
    assert plan.period is not None
    assert len({plan.stop, plan.surface, plan.up}) >= 2


def test_outputs_that_ride_with_its_words_are_what_the_vehicle_file_says_is_safe(
    tmp_path: Path,
) -> None:
    """A weight that hangs by a magnet is dropped by a 0."""
    text = vehicle_file("coreboard").read_text(encoding="utf-8")
    weight = "weight: {channel: passthrough2, high: 1, safe: 1, irreversible: true, ascent: 0}"
    servo = "servo: {channel: passthrough1, low: 60, high: 120, safe: 90}"
    vehicle = read_vehicle(text.replace("outputs:", f"outputs:\n  {weight}\n  {servo}\n", 1), "")
    homes = Homes(None, tmp_path / "pi", {})
    keep(Working(Configuration(folder=tmp_path / "pi"), vehicle), homes)
    DiskStore(tmp_path / "pi" / "store").keep_under_way("autonomous/out")
    plan = plan_from(["--folder", str(tmp_path / "pi")], {})
    assert plan is not None
    frame = link("coreboard.pc_to_main").frames(Tolerances())[0]
    for way in (plan.stop, plan.surface, plan.up):
        assert frame.decode(way[0])["passthrough"] == "5a01" + 9 * "00"


@pytest.mark.parametrize(
    ("under_way", "climbs"),
    [("autonomous/out", True), ("emergency/surfacing", True), ("emergency/stopped", False),
     ("emergency/surfaced", False), *((rest, False) for rest in (*STOPS, UNKNOWN))],
)  # fmt: skip
def test_it_climbs_by_what_was_under_way(tmp_path: Path, under_way: str, climbs: bool) -> None:
    plan = plan_from(["--folder", str(left(tmp_path, under_way).parent / "pi")], {})
    assert plan is not None
    assert plan.climbs == climbs


def test_where_nothing_was_under_way_there_is_no_boat_and_where_nobody_knows_one_that_waits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert plan_from(["-c", str(left(tmp_path, ""))], {}) is None
    (tmp_path / "pi" / "store" / "under-way").write_text("rubbish")
    for arguments in (["-c", str(tmp_path / "serve.yaml")], ["-c", str(tmp_path / "gone.yaml")]):
        plan = plan_from(arguments, {})
        assert plan is not None
        assert not plan.climbs


def test_a_record_that_is_no_table_is_none(tmp_path: Path) -> None:
    config = left(tmp_path, "autonomous/out")
    write_summed(tmp_path / "pi" / "working", json.dumps([1]))
    plan = plan_from(["-c", str(config)], {})
    assert plan is not None
    assert plan.url == Plan().url


@pytest.mark.parametrize("vehicle", ["mainboard", "motorboards"])
def test_records_are_what_linux_takes_for_a_frame_of_its_bus(vehicle: str, tmp_path: Path) -> None:
    built = pytest.importorskip("can.interfaces.socketcan.socketcan").build_can_frame
    can = pytest.importorskip("can")
    plan = plan_from(["-c", str(left(tmp_path, "autonomous/out", vehicle, url="can://can0"))], {})
    assert plan is not None
    records = [*plan.stop, *plan.up]
    made = [frame for frame in map(can_frame, records) if frame]
    assert made == [
        built(
            can.Message(arbitration_id=record[1], data=record[3:], is_extended_id=False, check=True)
        )
        for record in records
        if record[0] == 0
    ]
    assert len(made) == 4
    assert len(set(made)) == 3, "the force differs, and the torque does not"


def test_a_bus_is_bound_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    bound: list[tuple[str]] = []

    class Bus(socket.socket):
        def __init__(self, *asked: int) -> None:
            assert asked == (socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
            super().__init__(socket.AF_UNIX, socket.SOCK_DGRAM)

        def bind(self, address: tuple[str]) -> None:  # type: ignore[override]
            bound.append(address)

    monkeypatch.setattr("mission.onboard.lifeboat.socket.socket", Bus)
    port = opened(Plan("can://can0?sensors=/dev/ttyUSB1", 500_000))
    assert bound == [("can0",)]
    os.close(port)


@pytest.mark.parametrize("url", ["can://239.74.163.2?interface=udp_multicast", "memory://sea"])
def test_where_there_is_no_way_it_says_so_and_writes_to_no_other_port(url: str) -> None:
    with pytest.raises(SystemExit, match="only serial, tcp and can"):
        launch(Plan(url))


# --- as a process ---------------------------------------------------------------------------------


def test_a_board_on_the_network_is_told_its_way_up(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as board:
        board.settimeout(PATIENCE)
        url = f"tcp://127.0.0.1:{board.getsockname()[1]}"
        config = left(tmp_path, "autonomous/out", "coreboard", url=url)
        plan = plan_from(["-c", str(config)], {})
        assert plan is not None
        with launched(tmp_path, config, "transitions") as pi:
            try:
                for _ in range(2):  # the line is lost, and opened again
                    link, _ = board.accept()
                    link.settimeout(PATIENCE)
                    heard = b""
                    while plan.up[0] not in heard:
                        heard += link.recv(4096) or pytest.fail("it hung up")
                    link.close()
            finally:
                pi.send_signal(signal.SIGTERM)
            assert pi.wait(PATIENCE) == 0


def launched(folder: Path, config: Path, broken: str) -> subprocess.Popen[bytes]:
    (folder / "shadow").mkdir()
    (folder / "shadow" / f"{broken}.py").write_text(f"raise ImportError('{broken}')\n")
    return subprocess.Popen(
        [sys.executable, "-m", "mission", "serve", "--config", str(config)],
        env=os.environ | {"PYTHONPATH": str(folder / "shadow")},
        stderr=subprocess.DEVNULL,
    )


@pytest.mark.parametrize("broken", ["transitions", "click", "crcmod"])
def test_serve_that_cannot_be_loaded_brings_up_what_was_under_way(
    tmp_path: Path, broken: str
) -> None:
    with simulated(8.0) as sea:
        port = os.open(sea.paths[0], os.O_WRONLY | os.O_NOCTTY)
        os.write(port, b"@ZAD10$")
        os.close(port)
        soon(lambda: sea.vehicle.truth().depth > 2.0, "deep")
        with launched(
            tmp_path, left(tmp_path, "autonomous/out", device=sea.paths[0]), broken
        ) as pi:
            try:
                soon(lambda: sea.vehicle.truth().depth < 0.5, "up")
            finally:
                pi.send_signal(signal.SIGTERM)
            assert pi.wait(PATIENCE) == 0


def test_serve_that_cannot_be_loaded_ends_with_its_error_where_nothing_was_under_way(
    tmp_path: Path,
) -> None:
    with silent_board() as (master, device):
        with launched(tmp_path, left(tmp_path, "", device=device), "transitions") as pi:
            assert pi.wait(PATIENCE) == 1
        time.sleep(0.1)
        assert read_now(master) == b""
