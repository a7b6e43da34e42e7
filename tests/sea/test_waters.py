"""The sea itself: hull, thrusters, checksums and clock are what the papers and documents say."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.sea.body import Body, Gears
from tests.sea.clock import Clock
from tests.sea.laws import Law, held_deep, never, upward_within, word_within
from tests.sea.others import xor
from tests.sea.pi import ROOT
from tests.sea.receiver import Receiver
from tests.sea.scenes import PAIRS, SCENES
from tests.sea.stm32 import Board
from tests.sea.wire import Line, crc_modbus, crc_stm32, modem_frame


def settled(gears: Gears, seconds: float = 30.0, body: Body | None = None) -> Body:
    body = body or Body()
    for _ in range(round(seconds / 0.03)):
        body.step(gears, 0.03)
    return body


def up(gear: float) -> Gears:
    return Gears(up=(gear, gear, gear))


def test_a_body_without_thrust_floats_and_rises() -> None:
    body = settled(up(-10))
    assert body.rate() == pytest.approx(0.36, abs=0.03)
    assert settled(Gears(), 10, body).rate() == pytest.approx(-0.25, abs=0.03)
    assert settled(Gears(), 90, body).depth == pytest.approx(0.09, abs=0.05)


def test_below_gear_five_the_verticals_do_not_overcome_the_buoyancy() -> None:
    assert settled(up(-4)).depth < 0.3 < settled(up(-5)).depth


def test_gear_ten_is_full_speed() -> None:
    assert settled(up(-10)).depth == pytest.approx(settled(up(-12)).depth, abs=0.1)


def test_the_thrusters_lift_the_heaviest_body_of_the_scenes() -> None:
    body = settled(up(-10))
    body.buoyancy = -20.0
    settled(Gears(), 5, body)
    assert settled(up(12), 10, body).rate() < -0.15


def test_upside_down_up_pushes_down_and_letting_go_rises() -> None:
    body = settled(up(-10))
    body.turn_over()
    settled(Gears(), 8, body)
    assert abs(body.attitude()[0]) > 150
    assert abs(body.attitude_turned()[1]) > 150
    assert settled(up(12), 8, body).rate() > 0.2
    assert settled(Gears(), 10, body).rate() < -0.2


def test_the_hull_keeps_its_course_and_turns_by_its_mains() -> None:
    assert abs(settled(Gears(8, 8)).pose.w[2]) < math.radians(1)
    assert math.degrees(settled(Gears(8, -8)).pose.w[2]) == pytest.approx(12, abs=4)


def test_checksums_are_those_of_the_documents() -> None:
    assert crc_modbus(b"123456789") == 0x4B37
    assert crc_stm32(bytes.fromhex("78563412")) == 0xDF8A8A2B
    assert modem_frame(b"@DU$") == bytes.fromhex("230204000140445524" + "1486")
    assert xor(bytes.fromhex("feef05dc01")) == 0xC9


def test_a_report_is_86_bytes_with_a_sum_that_holds() -> None:
    line = Line(9600)
    report = Board(Body(), line).report(1000.0)
    line.close()
    assert len(report) == 86
    assert (report[:3], report[-1:]) == (b"@SD", b"$")
    assert int.from_bytes(report[81:85], "little") == crc_stm32(report[3:81])


def test_two_frames_in_one_burst_are_one_frame_to_the_board() -> None:
    line = Line(9600)
    board = Board(Body(), line)
    board.hear(1000.0, b"@ZAX0$@ZAU12$")
    board.hear(1000.1, b"")
    board.hear(1000.2, b"@ZAD8$")
    board.hear(1000.3, b"")
    line.close()
    assert [word.text for word in board.words] == ["@ZAX0$@ZAU12$", "@ZAD8$"]
    assert board.control(1000.3, 0.03).up == (-8.0, -8.0, -8.0)


@pytest.mark.parametrize(
    "law",
    [
        held_deep(2.0, "go", "due"),
        upward_within(5.0, "go"),
        word_within("@ZAX0", 5.0, "go"),
        never("@ZAU", "go", "nobody asked for it"),
    ],
)
def test_a_law_about_what_a_scene_never_came_to_is_broken(law: Law) -> None:
    nothing = SimpleNamespace(marks={"due": 9.0}, samples=[], board=SimpleNamespace(words=[]))
    assert law(nothing) == "the scene never came to 'go'"  # type: ignore[arg-type]


def test_the_scenes_are_found_by_hand_as_by_pytest() -> None:
    listed = subprocess.run(
        [sys.executable, "-m", "tests.sea", "--list"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    names = [line.split()[0] for line in listed.stdout.splitlines()]
    assert names == [scene.name for scene in (*SCENES, *PAIRS)]
    assert len(set(names)) == len(names), "a name says which one is flown"


FROZEN = """
import errno, os, sys
kept = open("kept").read()
acts = (lambda: open("new", "w"), lambda: open("kept", "ab"), lambda: os.remove("kept"),
        lambda: os.replace("kept", "other"), lambda: os.mkdir("folder"))
for act in acts:
    try:
        act()
    except OSError as error:
        kept += f" {errno.errorcode[error.errno]}"
print(kept)
"""


def test_a_read_only_folder_can_be_read_and_not_changed(tmp_path: Path) -> None:
    (tmp_path / "kept").write_text("kept")
    clock = Clock()
    code = FROZEN.replace('"kept"', repr(str(tmp_path / "kept")))
    for name in ("new", "other", "folder"):
        code = code.replace(f'"{name}"', repr(str(tmp_path / name)))
    done = subprocess.run(
        [sys.executable, "-c", code, "serve"],
        env={**os.environ, **clock.environment(), "SEA_READ_ONLY": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    clock.close()
    assert done.stdout.split() == ["kept", *["EROFS"] * 5]
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]


def test_a_receiver_tells_places_at_its_own_pace_and_with_its_own_habits() -> None:
    line = Line(9600)
    receiver = Receiver(Body(), line, period=0.5, checked=False, date="310799")
    said: list[bytes] = []
    line.send = lambda _now, data: said.append(data)  # type: ignore[method-assign]
    for tick in range(1000):
        receiver.tick(1000 + tick / 100)
    line.close()
    assert len(said) in (19, 20)
    assert b",310799," in said[-1]
    assert b"*" not in b"".join(said)


def test_a_port_that_vanished_is_found_again_by_its_name(tmp_path: Path) -> None:
    line = Line(9600)
    line.link(tmp_path / "serial0")
    line.vanish()
    assert not (tmp_path / "serial0").exists()
    line.come_back()
    with (tmp_path / "serial0").open("wb", buffering=0) as port:
        port.write(b"@ZAX0$")
        heard = b""
        while len(heard) < 6:
            heard += line.receive()
    assert heard == b"@ZAX0$"
    line.close()
