"""The acoustic channel between two processes: the real serve and the real commands of the boat."""

from __future__ import annotations

import json
import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from programs import process, run
from served import ASKED_AGAIN, PATIENCE, TEXT, soon

from links.acoustic import SOUND_SPEED, Water
from links.serial import SerialLink
from links.simulated.water import PAUSE_S, Channel


def told(started: subprocess.Popen[str]) -> Any:
    assert started.stdout is not None
    return json.loads(started.stdout.readline())


@contextmanager
def channel(water: Water) -> Iterator[tuple[SerialLink, SerialLink, Channel]]:
    over = threading.Event()
    with Channel(water, 1) as made:
        thread = threading.Thread(target=made.run, args=(over.is_set,))
        thread.start()
        boat, vehicle = (
            SerialLink(name, path) for name, path in zip("bv", made.paths, strict=True)
        )
        try:
            yield boat, vehicle, made
        finally:
            boat.close()
            vehicle.close()
            over.set()
            thread.join()


def heard(link: SerialLink, size: int) -> tuple[bytes, float]:
    data = b""

    def all_there() -> bool:
        nonlocal data
        data += b"".join(rx.data for rx in link.receive(0.0))
        return len(data) >= size

    soon(all_there, "the burst")
    return data, time.monotonic()


def test_a_burst_arrives_whole_after_its_way_and_its_length() -> None:
    water = Water(range_m=450.0, bit_rate=2000.0)
    with channel(water) as (boat, vehicle, _):
        begun = time.monotonic()
        boat.send(b"x" * 100, 0.0)
        boat.send(b"y" * 100, 0.0)
        time.sleep(0.9)
        assert vehicle.receive(0.0) == [], "nothing before its end"
        data, there = heard(vehicle, 200)
    assert data == b"x" * 100 + b"y" * 100
    assert there - begun >= 450.0 / SOUND_SPEED + 8 * 200 / 2000.0 + PAUSE_S


def test_who_talks_hears_nothing() -> None:
    with channel(Water(range_m=0.0, bit_rate=1000.0)) as (boat, vehicle, made):
        boat.send(b"b" * 50, 0.0)
        vehicle.send(b"v" * 50, 0.0)
        soon(lambda: sum(t.collided for t in made.tallies.values()) == 2, "both collide")
        assert boat.receive(0.0) == []
        assert vehicle.receive(0.0) == []


@pytest.mark.parametrize("water", [Water(0.0, 1e6, loss=1.0), Water(0.0, 1e6, bit_error_rate=0.5)])
def test_what_is_lost_or_damaged_does_not_arrive_as_it_was(water: Water) -> None:
    with channel(water) as (boat, vehicle, made):
        boat.send(b"b" * 50, 0.0)
        soon(lambda: made.tallies["boat"].bursts == 1, "the burst")
        time.sleep(0.2)
        assert b"".join(rx.data for rx in vehicle.receive(0.0)) != b"b" * 50


@pytest.mark.proof
def test_an_operator_rehearses_a_dive_by_modem_with_the_real_programs(tmp_path: Path) -> None:
    mission, ready = tmp_path / "pool.txt", tmp_path / "ready.json"
    mission.write_text(TEXT)
    water = ("--range", "150", "--rate", "20000", "--folder", str(tmp_path / "water"))
    with process("water", *water, "--json") as channel_process:
        ends = told(channel_process)
        place = ("--folder", str(tmp_path / "auv"), "--modem", ends["vehicle"])
        with process("vehicle", "auv", *place, "--json") as sea:
            config = told(sea)["config"]
            words = ("-c", config, "--topside", "tcp://127.0.0.1:0", "--ready-file", str(ready))
            with process("serve", *words):
                soon(ready.exists, "serve")
                to = ("--to", ends["boat"])
                soon(lambda: "latitude" in run("status", *to).stdout, "a fix", pause=ASKED_AGAIN)
                assert run("limits", "--depth", "9", *to).exit_code == 0
                assert run("rudder", "left", "5", *to).exit_code == 0
                assert "AUTO          open" in run("nodes", *to).stdout
                refused = run("time", *to)
                assert refused.exit_code == 1
                assert "not set by modem" in refused.stderr
                stored = run("upload", str(mission), *to)
                assert stored.exit_code == 0, stored.stderr
                radio = json.loads(ready.read_text())["topside"]  # by modem a refusal lasts 2 min
                started = run("start", "--to", radio, "--wait", "60")
                assert started.exit_code == 0, started.stderr
                assert "autonomous" in run("status", *to).stdout
                assert "stop" in run("stop", *to).stderr
                assert run("surface", *to).exit_code == 0
        channel_process.send_signal(signal.SIGINT)
        assert channel_process.wait(PATIENCE) == 130
    assert list((tmp_path / "water").iterdir()) == []


def test_where_every_burst_is_lost_nothing_is_called_done(tmp_path: Path) -> None:
    words = ("--loss", "1", "--range", "1", "--rate", "1000000", "--folder", str(tmp_path))
    with process("water", *words, "--json") as channel_process:
        ends = told(channel_process)
        assert str((tmp_path / "boat").readlink()).startswith("/dev/")
        ran = run("limits", "--depth", "9", "--to", ends["boat"], "--json")
    assert ran.exit_code == 1
    assert json.loads(ran.stdout)["ok"] is False
