"""CAN frames as records on python-can's virtual bus."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from link_pair import multicast
from served import soon

from links import LinkAddressError, check_url, open_link
from links.base import Link, LinkAbsent, LinkClosed, LinkError

can = pytest.importorskip("can", reason="python-can is not installed: pip install auvmission[can]")

FORCE = bytes.fromhex("0001 07 FF001000200030")
TORQUE = bytes.fromhex("0002 07 FE001000200030")


def opened(name: str) -> Link:
    return open_link(name, "can://bench?interface=virtual")


@pytest.fixture
def pair() -> Iterator[tuple[Link, Link]]:
    near, far = opened("pi"), opened("board")
    yield near, far
    near.close()
    far.close()


def test_records_arrive_one_by_one_on_the_other_side(pair: tuple[Link, Link]) -> None:
    near, far = pair
    near.send(FORCE + TORQUE, 1.0)
    assert [(rx.t, rx.link, rx.data) for rx in far.receive(2.0)] == [
        (2.0, "board", FORCE),
        (2.0, "board", TORQUE),
    ]
    assert near.receive(2.0) == []
    assert (near.fileno(), near.next_event()) == (-1, None)


def test_frames_that_no_record_carries_are_counted_and_dropped(pair: tuple[Link, Link]) -> None:
    _, far = pair
    with can.Bus(channel="bench", interface="virtual") as other:
        other.send(can.Message(arbitration_id=0x1FF00001, data=b"x", is_extended_id=True))
        other.send(can.Message(arbitration_id=1, is_remote_frame=True, is_extended_id=False))
        other.send(can.Message(arbitration_id=1, data=b"x", is_extended_id=False))
    assert [rx.data for rx in far.receive(0.0)] == [b"\x00\x01\x01x"]
    assert far.skipped == 2  # type: ignore[attr-defined]


@pytest.mark.parametrize("data", [b"\x00", FORCE[:-1], b"\x08\x00\x00", b"\x00\x01\x09" + bytes(9)])
def test_what_is_no_record_is_an_error_of_the_sender(pair: tuple[Link, Link], data: bytes) -> None:
    with pytest.raises(LinkError, match="no sequence of CAN records"):
        pair[0].send(data, 0.0)
    assert pair[1].receive(0.0) == []


def test_a_closed_bus_says_so_and_may_be_closed_twice(pair: tuple[Link, Link]) -> None:
    near, _ = pair
    near.close()
    near.close()
    assert near.fileno() == -1
    for use in (lambda: near.receive(0.0), lambda: near.send(FORCE, 0.0)):
        with pytest.raises(LinkClosed):
            use()


def test_a_bus_that_fails_under_way_is_closed(pair: tuple[Link, Link]) -> None:
    near, _ = pair
    near.bus.shutdown()  # type: ignore[attr-defined]
    for use in (lambda: near.receive(0.0), lambda: near.send(FORCE, 0.0)):
        with pytest.raises(LinkClosed, match="pi: "):
            use()


def test_a_bus_off_closes_the_link_and_another_error_is_counted(pair: tuple[Link, Link]) -> None:
    near, far = pair
    for class_, is_off in ((0x20, False), (0x40, True), (0x44, True)):
        told = can.Message(
            arbitration_id=class_, is_error_frame=True, is_extended_id=False, data=bytes(8)
        )
        far.bus.send(told)  # type: ignore[attr-defined]
        if is_off:
            with pytest.raises(LinkClosed, match="pi: the bus is off"):
                near.receive(0.0)
        else:
            assert near.receive(0.0) == []
    assert near.skipped == 1  # type: ignore[attr-defined]


@pytest.mark.parametrize(("carrier", "absent"), [("0\n", True), ("1\n", False), (None, False)])
def test_a_bus_of_linux_without_a_carrier_is_absent(
    carrier: str | None, absent: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is sent then is dropped by the kernel as if it had left."""
    if carrier is not None:
        (tmp_path / "can0").mkdir()
        (tmp_path / "can0" / "carrier").write_text(carrier)
    really, shut = can.Bus, []

    def virtual(channel: str, interface: str, bitrate: int) -> object:
        assert interface == "socketcan"
        bus = really(channel=channel, interface="virtual", bitrate=bitrate)
        monkeypatch.setattr(bus, "shutdown", lambda: shut.append(1))
        return bus

    monkeypatch.setattr(can, "Bus", virtual)
    monkeypatch.setattr("links.can.INTERFACES", tmp_path)
    if absent:
        with pytest.raises(LinkAbsent, match="the CAN bus can0 has no carrier"):
            open_link("pi", "can://can0")
        assert shut == [1]
    else:
        open_link("pi", "can://can0").close()


def test_an_absent_bus_is_named_with_what_to_do() -> None:
    with pytest.raises(
        LinkAbsent,
        match=r"vehicle: no CAN bus can9 .*ip link set can9 up type can bitrate 500000 restart-ms 100 one-shot on",
    ):
        open_link("vehicle", "can://can9")
    with pytest.raises(LinkAbsent, match="no CAN bus x by carrier-pigeon"):
        open_link("vehicle", "can://x?interface=carrier-pigeon")
    with pytest.raises(LinkAddressError, match="can://can0"):
        open_link("vehicle", "can://")


def test_without_python_can_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "can", None)
    with pytest.raises(LinkAbsent, match=r"auvmission\[can\]"):
        opened("vehicle")


def test_a_setpoint_crosses_a_bus_and_is_read_by_the_motor_boards_table(
    pair: tuple[Link, Link],
) -> None:
    from protocol.messages import Setpoint
    from protocol.vehicles import codec, link

    near, far = pair
    for data in codec("motorcan", "documented", {}).encode(Setpoint(surge=0.5, turn=-1.0)):
        near.send(data, 0.0)
    framer = link("coreboard.can").framer()
    frames = [f for rx in far.receive(0.0) for f in framer.receive(rx.data, rx.t)]
    assert [f.values() for f in frames] == [
        {"fx_g": 2500, "fy_g": 0, "fz_g": 0},
        {"mx_nm": 0, "my_nm": 0, "mz_nm": -20},
    ]


@pytest.mark.skipif(not multicast(), reason="no UDP multicast here")
def test_two_buses_of_one_computer_hear_nothing_of_each_other() -> None:
    """python-can hears every group of its port: each has a port of its own."""
    urls = [f"can://239.74.163.{4 + i}:{43114 + i}?interface=udp_multicast" for i in (0, 0, 1)]
    near, far, other = (open_link("bus", url) for url in urls)
    try:
        near.send(FORCE, 0.0)
        heard: list[bytes] = []
        soon(lambda: heard.extend(rx.data for rx in far.receive(0.0)) or bool(heard), "the frame")
        assert heard == [FORCE]
        assert other.receive(0.0) == []
    finally:
        for link in (near, far, other):
            link.close()


def test_a_port_is_of_buses_by_udp_alone() -> None:
    with pytest.raises(LinkAddressError, match="a port is of interface=udp_multicast alone"):
        check_url("can://can0:43113")
