"""The table of rows has every field of every frame of the documents, and leaves no cell empty."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from from_code.rows import BY_HAND, DERIVED, DOCUMENTS, NOBODY, TOOLS, UP, rows

from protocol.examples import examples
from protocol.vehicles import frame_types
from protocol.vehicles.robot import COMMANDS

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def table() -> list[tuple[str, ...]]:
    return [row for document in DOCUMENTS for row in rows(document)]


@pytest.mark.proof
def test_every_frame_and_every_field_of_it_is_a_row(table: list[tuple[str, ...]]) -> None:
    shown = {(frame.strip("`"), field.strip("`")) for frame, field, *_ in table}
    assert {frame for frame, _ in shown} == set(frame_types())
    for example in examples():
        if example.type in ("auv.ZA", "robot.DOWN"):
            continue
        values = frame_types()[example.type].decode(example.raw)
        assert {(example.type, name) for name in values if name not in DERIVED} <= shown
    robot = [field for frame, field in shown if frame == "robot.DOWN"]
    assert len(robot) == len(COMMANDS)


def test_an_acknowledgement_has_its_masks_among_its_rows(table: list[tuple[str, ...]]) -> None:
    shown = {field.strip("`") for frame, field, *_ in table if frame == "`auv.ACK`"}
    assert shown == {"class", "func", "ok", "mask", "nodes", "sensors", "code"}


def test_a_file_that_is_said_to_test_a_row_is_there(table: list[tuple[str, ...]]) -> None:
    files = {path.stem for path in (ROOT / "tests").rglob("test_*.py")}
    named = {name for row in table for name in re.findall(r"`(test_\w+)`", row[-1])}
    assert named == {"test_rows_of_documents", "test_every_row_by_hand"} <= files


def test_no_cell_is_empty(table: list[tuple[str, ...]]) -> None:
    assert not [row for row in table if not all(row)]


def test_what_a_board_reports_is_read_into_telemetry_or_told_why_not(
    table: list[tuple[str, ...]],
) -> None:
    for frame, field, read, *_ in table:
        name = frame.strip("`")
        if name in UP and field.strip("`") not in NOBODY.get(name, {}):
            assert read.startswith("`Telemetry."), (frame, field, read)


def test_of_what_a_board_reports_what_never_varies_is_what_the_page_names(
    table: list[tuple[str, ...]],
) -> None:
    """Sensors that nothing is behind in the simulator; all else varies, or by a fault."""
    still = {row[1].strip("`") for row in table if row[4] == "constant"}
    usbl = {f"usbl{n}" for n in range(1, 7)} | {"usbl_x_m", "usbl_y_m"}
    reserved = {"reserved50", "reserved83", "reserved12", "reserved18", "reserved124", "buf"}
    dvl = {"dvl_y", "dvl_z"} | {f"vo_{axis}" for axis in "xyz"}
    named = {"x_m", "y_m", "avoid_m", "mode", "metal_pct", "battery_control", "battery_power"}
    named |= {"temperature_c", "temperature2_c", "mx", "my", "mz", "ad1", "ad2", "ad3", "ad4"}
    assert still == usbl | reserved | dvl | named


def test_what_a_board_hears_is_written_by_something_or_told_why_not(
    table: list[tuple[str, ...]],
) -> None:
    alone = [row[:2] for row in table if row[3] == BY_HAND]
    assert alone == [("`auv.ZA`", "`V`")]  # which the STM32 refuses by its document


def test_nothing_is_excused_that_is_there(table: list[tuple[str, ...]]) -> None:
    """An excuse for a field that does something would hide it."""
    told = {(row[0].strip("`"), row[1].strip("`")): row[2] for row in table}
    for name, fields in NOBODY.items():
        for field, why in fields.items():
            assert told[name, field] == why != TOOLS
