"""The simulated vehicle behind pseudo-terminals: the same bytes, at the pace of the wire."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from itertools import pairwise

import pytest

from links.serial import SerialLink
from links.simulated.link import SimulatedVehicle
from links.simulated.pty import PtyVehicle, run_on_ptys
from links.simulated.settings import Settings

SPEED = 20.0


class Served:
    def __init__(self, vehicle: PtyVehicle) -> None:
        self.begin = time.monotonic()
        self.stm32 = SerialLink("vehicle", vehicle.paths[0])
        self.gps = SerialLink("gps", vehicle.paths[1])

    def listen(self, seconds: float, link: SerialLink | None = None) -> list[tuple[float, bytes]]:
        """For so many seconds of real time."""
        out, end = [], time.monotonic() + seconds
        while time.monotonic() < end:
            for rx in (link or self.stm32).receive(time.monotonic() - self.begin):
                out.append((rx.t, rx.data))  # noqa: PERF401
            time.sleep(0.001)
        return out


@pytest.fixture
def served() -> Iterator[Served]:
    stop = threading.Event()
    vehicle = SimulatedVehicle("as-built", 1, Settings(splice=0.0))
    with PtyVehicle(vehicle, SPEED) as on_ptys:
        thread = threading.Thread(target=on_ptys.run, kwargs={"stop": stop.is_set})
        thread.start()
        made = Served(on_ptys)
        yield made
        stop.set()
        thread.join(5.0)
        made.stm32.close()
        made.gps.close()
        assert not thread.is_alive()


def test_both_lines_carry_the_bytes_of_the_same_flight(served: Served) -> None:
    heard = b"".join(data for _, data in served.listen(0.6))
    sentences = b"".join(data for _, data in served.listen(0.1, served.gps))
    twin = SimulatedVehicle("as-built", 1, Settings(splice=0.0))
    assert len(heard) >= 4 * 86
    assert b"".join(rx.data for rx in twin.vehicle_link.receive(100.0)).startswith(heard)
    assert b"".join(rx.data for rx in twin.gps_link.receive(100.0)).startswith(sentences)
    assert sentences.startswith(b"$GPGGA,080001.00")


def test_a_command_is_answered_and_obeyed(served: Served) -> None:
    served.stm32.send(b"@ZAF6$", 0.0)
    heard = b"".join(data for _, data in served.listen(0.5))
    assert b"@ACK_ZAY$" in heard
    reports = [heard[i : i + 86] for i in range(len(heard)) if heard[i : i + 3] == b"@SD"]
    assert reports[-2][63:67] == b"\xd6\x06\xd6\x06"  # 1750 us, both mains


def test_faster_than_real_time_frames_come_whole_at_the_pace_times_the_speed(
    served: Served,
) -> None:
    pieces = served.listen(0.9)
    gaps = [b - a for (a, _), (b, _) in pairwise(pieces)]
    assert {len(data) for _, data in pieces} == {86}
    assert sorted(gaps)[len(gaps) // 2] == pytest.approx(2.0 / SPEED, abs=0.03)


def test_in_real_time_a_frame_comes_piece_by_piece() -> None:
    stop = threading.Event()
    with PtyVehicle(SimulatedVehicle("as-built", 1, Settings(splice=0.0)), 1.0) as on_ptys:
        thread = threading.Thread(target=on_ptys.run, kwargs={"stop": stop.is_set})
        thread.start()
        line = Served(on_ptys)
        pieces = line.listen(1.5)  # the first report begins after 1 s
        stop.set()
        thread.join(5.0)
        line.stm32.close()
        line.gps.close()
    assert len(pieces) >= 4
    assert sum(len(data) for _, data in pieces) == 86
    assert pieces[-1][0] - pieces[0][0] > 0.03  # of the 90 ms that a frame takes


def test_it_runs_to_its_end_with_nobody_listening_and_says_its_paths() -> None:
    said: list[str] = []
    vehicle = SimulatedVehicle("documented", 2)
    run_on_ptys(vehicle, 400.0, ready=lambda *paths: said.extend(paths), until=120.0)
    assert vehicle.now == pytest.approx(120.0, abs=15.0)
    assert len(said) == 2
    assert said[0] != said[1]


def test_a_speed_of_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="above 0"):
        PtyVehicle(SimulatedVehicle(), 0.0)
