"""A CAN bus and a serial line as one link: each gets its own bytes, and both wake the reader."""

from __future__ import annotations

import os
import select
from pathlib import Path

import pytest
from served import silent_board

from links import LinkAddressError, check_url, open_link
from links.base import LinkAbsent, Rx
from links.joined import JoinedLink
from mission.model.shipped import load_vehicle
from protocol.messages import Setpoint
from protocol.vehicles import codec, link


class End:
    """One of the two, on a pipe."""

    def __init__(self) -> None:
        self.out, self.into = os.pipe()
        os.set_blocking(self.out, False)
        self.said: list[bytes] = []
        self.closed = False

    def fileno(self) -> int:
        return self.out

    def receive(self, now: float) -> list[Rx]:
        try:
            return [Rx(now, "vehicle", os.read(self.out, 100))]
        except BlockingIOError:
            return []

    def send(self, data: bytes, now: float, address: str = "") -> None:
        self.said.append(data)

    def next_event(self) -> float | None:
        return None

    def close(self) -> None:
        if not self.closed:
            os.close(self.out)
            os.close(self.into)
        self.closed = True


def test_force_and_torque_go_to_the_bus_and_the_rest_to_the_line() -> None:
    bus, line = End(), End()
    both = JoinedLink("vehicle", bus, line)
    for frame in codec("mainboard", "documented", {}).encode(Setpoint(surge=0.5)):
        both.send(frame, 0.0)
    assert [data[:2] for data in bus.said] == [b"\x00\x01", b"\x00\x02"]
    assert len(line.said) == 1
    (told,) = link("coreboard.main_to_sensor").framer().receive(line.said[0], 0.0)
    assert told.values()["depth"] == 1  # type: ignore[union-attr]
    both.close()
    assert bus.closed
    assert line.closed
    assert both.fileno() == -1


@pytest.mark.parametrize("speaks", [0, 1])
def test_who_waits_for_it_wakes_for_either_and_hears_the_line_alone(speaks: int) -> None:
    ends = End(), End()
    both = JoinedLink("vehicle", *ends)
    assert not select.select([both.fileno()], [], [], 0.0)[0]
    os.write(ends[speaks].into, b"\x00\x01\x00")
    assert select.select([both.fileno()], [], [], 1.0)[0]
    assert [rx.data for rx in both.receive(1.0)] == [b"\x00\x01\x00"][:speaks]
    assert not select.select([both.fileno()], [], [], 0.0)[0], "nothing is left to be read"
    both.close()


def test_a_bus_may_name_the_line_of_its_sensor_board_and_neither_opens_without_the_other(
    tmp_path: Path,
) -> None:
    bus = "can://test?interface=virtual"
    with silent_board() as (_, device):
        made = open_link("vehicle", f"{bus}&sensors={device}")
        assert isinstance(made, JoinedLink)
        made.close()
        with pytest.raises(LinkAbsent):
            open_link("vehicle", f"can://none0?sensors={device}")
        open_link("vehicle", f"serial://{device}").close()  # it was left as it was
    with pytest.raises(LinkAbsent):
        open_link("vehicle", f"{bus}&sensors={tmp_path / 'gone'}")
    with pytest.raises(LinkAddressError, match="baud"):
        check_url(f"{bus}&sensors=/dev/ttyUSB1&baud=fast")


def test_the_shipped_vehicle_speaks_to_both() -> None:
    assert load_vehicle("mainboard").codec == "mainboard"
