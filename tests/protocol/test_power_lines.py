"""Document 004: the text that goes on to the power module, and lengths that say less than is there."""

from __future__ import annotations

import pytest

from protocol.checksum import sum255
from protocol.framing import Frame
from protocol.messages import FrameFault
from protocol.vehicles import link, robot
from protocol.vehicles.robot import COMMANDS, POWER, Command

LINES = [
    (0, {}, "AT\r\n"),
    (1, {}, "AT+V\r\n"),
    (2, {}, "AT+C\r\n"),
    (3, {}, "AT+P\r\n"),
    (4, {"max_current_a": 12}, "AT+MAXC+12\r\n"),
    *((5, {"alarm_mode": i + 1}, f"AT+MODE+{name}\r\n") for i, name in enumerate(
        ("OVERV", "UNDERV", "OVERC", "UNDERC", "OVERP"))),
    (6, {"thousandths": 36_000}, "AT+OVERVERR+36\r\n"),
    (7, {"thousandths": 21_000}, "AT+UNDERVERR+21\r\n"),
    (7, {"thousandths": 10_500}, "AT+UNDERVERR+10.5\r\n"),
    (8, {"thousandths": 1}, "AT+OVERCERR+0.001\r\n"),
    (9, {"thousandths": 0}, "AT+UNDERCERR+0\r\n"),
    (10, {"thousandths": 1_080_000}, "AT+OVERPERR+1080\r\n"),
]  # fmt: skip
SIZED = [row for row in COMMANDS if row.length]


def heard(raw: bytes) -> Frame | FrameFault:
    framer = link("robot.down").framer()
    return (framer.receive(raw, 0.0) + framer.flush(1.0))[0]


def framed(row: Command, length: int, user: bytes) -> bytes:
    body = bytes((0xAA, row.address, row.command, length)) + user.ljust(6, b"\0")
    return body + bytes((sum255(body), 0xDD))


@pytest.mark.parametrize(("code", "values", "text"), LINES)
def test_every_power_command_says_its_whole_line_with_value_and_line_end(
    code: int, values: dict[str, int], text: str
) -> None:
    frame = link("robot.down").frames.__call__(robot.Tolerances())[0]
    raw = frame.encode({"address": POWER, "command": code, **values})
    found = heard(raw)
    assert isinstance(found, Frame)
    assert found.values()["at"] == text
    assert found.values()["flags"] == []


def test_every_power_command_has_such_a_line() -> None:
    assert {code for code, _, _ in LINES} == {r.command for r in COMMANDS if r.address == POWER}


@pytest.mark.parametrize("row", SIZED, ids=lambda row: f"{row.address}-{row.command:02X}")
def test_a_length_that_leaves_out_bytes_of_the_value_is_refused(row: Command) -> None:
    """G4: whole or not at all."""
    user = b"".join(item.write(max(item.low, 1)) for item in row.items)
    for length in range(row.length):
        found = heard(framed(row, length, user))
        assert isinstance(found, FrameFault), length
        assert found.kind == "bad_length"
    for length in range(row.length, 7):
        found = heard(framed(row, length, user))
        assert isinstance(found, Frame), length
        told = found.values()["flags"]
        assert told == ([] if length == row.length else ["length:disagrees"])
