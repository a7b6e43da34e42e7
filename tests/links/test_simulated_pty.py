"""The simulated vehicle behind pseudo-terminals: the same bytes, at the pace of the wire."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import pytest

from links.serial import SerialLink
from links.simulated import pty
from links.simulated.boards import SimulatedBoard
from links.simulated.firmware.uart import BYTE_TIME
from links.simulated.link import SimulatedVehicle
from links.simulated.pty import PtyVehicle, run_on_ptys
from links.simulated.settings import Settings, parse_settings


class Line:
    """The other process; the vehicle's time goes on by as much as the test says."""

    def __init__(self, speed: float) -> None:
        self.vehicle = PtyVehicle(SimulatedVehicle("as-built", 1, Settings(splice=0.0)), speed)
        self.stm32 = SerialLink("vehicle", self.vehicle.paths[0])
        self.gps = SerialLink("gps", self.vehicle.paths[1])

    def pieces(self, until: float) -> list[tuple[float, bytes]]:
        """From the STM32, with the simulated time at which each could be read first."""
        out, now = [], self.vehicle.vehicle.now
        while now < until:
            now += STEP
            self.vehicle.step(now)
            out += [(now, rx.data) for rx in self.stm32.receive(now)]
        return out

    def close(self) -> None:
        self.vehicle.close()
        self.stm32.close()
        self.gps.close()


STEP = 0.005  # s


@pytest.fixture
def line(request: pytest.FixtureRequest) -> Iterator[Line]:
    made = Line(getattr(request, "param", 20.0))
    yield made
    made.close()


def test_both_lines_carry_the_bytes_of_the_same_flight(line: Line) -> None:
    heard = b"".join(data for _, data in line.pieces(12.0))
    sentences = b"".join(rx.data for rx in line.gps.receive(12.0))
    twin = SimulatedVehicle("as-built", 1, Settings(splice=0.0))
    assert len(heard) >= 4 * 86
    assert b"".join(rx.data for rx in twin.vehicle_link.receive(100.0)).startswith(heard)
    assert b"".join(rx.data for rx in twin.gps_link.receive(100.0)).startswith(sentences)
    assert sentences.startswith(b"$GPGGA,080001.00")


def test_a_command_is_answered_and_obeyed(line: Line) -> None:
    line.stm32.send(b"@ZAF6$", 0.0)
    heard = b"".join(data for _, data in line.pieces(10.0))
    assert b"@ACK_ZAY$" in heard
    reports = [heard[i : i + 86] for i in range(len(heard)) if heard[i : i + 3] == b"@SD"]
    assert reports[-2][63:67] == b"\xd6\x06\xd6\x06"  # 1750 us, both mains


@pytest.mark.parametrize("line", [20.0], indirect=True)
def test_faster_than_real_time_frames_come_whole_when_their_last_byte_is_through(
    line: Line,
) -> None:
    pieces = line.pieces(18.0)
    assert {len(data) for _, data in pieces} == {86}
    first, gaps = pieces[0][0], [b - a for (a, _), (b, _) in pairwise(pieces)]
    assert first == pytest.approx(1.0 + 86 * BYTE_TIME, abs=2 * STEP)
    assert gaps == pytest.approx([2.0] * len(gaps), abs=2 * STEP)


@pytest.mark.parametrize("line", [1.0], indirect=True)
def test_in_real_time_a_frame_comes_piece_by_piece(line: Line) -> None:
    pieces = line.pieces(1.5)  # the first report begins after 1 s
    assert sum(len(data) for _, data in pieces) == 86
    assert len(pieces) >= 4
    assert pieces[-1][0] - pieces[0][0] > 0.07  # of the 90 ms that a frame takes


def test_the_clock_of_this_computer_drives_it_so_many_times_as_fast(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Whatever it sleeps, and however late it wakes."""
    clock = iter(range(1000))
    monkeypatch.setattr(pty.time, "monotonic", lambda: 0.01 * next(clock))
    with PtyVehicle(SimulatedVehicle("as-built", 1), 20.0) as vehicle:
        steps: list[float] = []
        monkeypatch.setattr(vehicle, "step", steps.append)
        vehicle.run(stop=lambda: len(steps) == 30)
    assert steps == pytest.approx([0.2 * (turn + 1) for turn in range(30)])


def test_it_runs_to_its_end_with_nobody_listening_and_says_its_paths() -> None:
    said: list[str] = []
    vehicle = SimulatedVehicle("documented", 2)
    run_on_ptys(vehicle, 400.0, ready=lambda *paths: said.extend(paths), until=120.0)
    assert vehicle.now == pytest.approx(120.0, abs=0.05)
    assert len(said) == 2
    assert said[0] != said[1]


def test_a_speed_of_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="above 0"):
        PtyVehicle(SimulatedVehicle(), 0.0)


def test_it_wakes_for_every_report_of_a_board(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, pauses = iter(range(1000)), list[float]()
    monkeypatch.setattr(pty.time, "monotonic", lambda: 0.01 * next(clock))
    monkeypatch.setattr(pty.select, "select", lambda *lists: pauses.append(lists[3]))
    board = SimulatedBoard("rov", 1)
    with PtyVehicle(board, 1.0) as vehicle:
        vehicle.run(stop=lambda: len(pauses) == 30)
    assert max(pauses) <= board.board.period


def test_sensors_that_were_added_have_a_port_of_their_own() -> None:
    settings = parse_settings(["doppler_pd0=0.03", "speed_log=0.1"])
    vehicle = SimulatedVehicle("as-built", 1, settings)
    with PtyVehicle(vehicle, 20.0) as served:
        port, heard = SerialLink("sensors", served.paths[2]), b""
        for step in range(1, 101):
            served.step(0.05 * step)
            heard += b"".join(rx.data for rx in port.receive(0.05 * step))
        port.close()
    twin = SimulatedVehicle("as-built", 1, settings)
    assert twin.added_link is not None
    assert b"".join(rx.data for rx in twin.added_link.receive(5.0)) == heard
    assert heard.count(b"\x7f\x7f") == heard.count(b"$VDVHW") == 4
