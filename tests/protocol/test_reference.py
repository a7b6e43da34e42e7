"""docs/protocol.md is what the tables say, and says something of every type."""

from __future__ import annotations

from pathlib import Path
from runpy import run_path

import pytest
from canonical_auv import AUV

from protocol.drawing import WIDTH
from protocol.errata import ERRATA, errata_of
from protocol.examples import examples
from protocol.reference import reference
from protocol.tolerances import TOLERANCES
from protocol.units import unit
from protocol.vehicles import VEHICLES, frame_types

FILE = Path(__file__).resolve().parents[2] / "docs" / "protocol.md"
TEXT = reference()


def section(name: str) -> str:
    return TEXT.split(f"### {name}\n")[1].split("\n### ")[0].split("\n## ")[0]


def test_the_file_in_docs_is_up_to_date() -> None:
    assert FILE.read_text(encoding="utf-8") == TEXT, (
        "python -m protocol.reference > docs/protocol.md"
    )


def test_the_module_prints_it(capsys: pytest.CaptureFixture[str]) -> None:
    run_path(str(FILE.parents[1] / "protocol" / "reference.py"), run_name="__main__")
    assert capsys.readouterr().out == TEXT


@pytest.mark.parametrize("name", frame_types())
def test_every_type_is_drawn_and_has_an_example_and_every_name_is_explained(name: str) -> None:
    text = section(name)
    assert text.count("```text") >= 2
    assert "+--" in text
    frame = frame_types()[name]
    raws = [example.raw for example in examples() if example.type == name]
    assert raws
    for raw in raws:
        assert frame.check(raw) is None
        for value in frame.decode(raw):
            assert value == "flags" or value in text


@pytest.mark.parametrize("name", [n for n in frame_types() if not n.startswith("auv")])
def test_the_offset_of_every_field_stands_above_its_box(name: str) -> None:
    drawing = section(name).split("```text")[1].split("```")[0].strip("\n").split("\n")
    assert max(map(len, drawing)) <= WIDTH
    last = 0
    for offsets, boxes in zip(drawing[0::4], drawing[2::4], strict=True):
        edges = [i for i, char in enumerate(boxes) if char == "|"]
        numbers = [int(offsets[edge:].split()[0]) for edge in edges]
        assert numbers == sorted(set(numbers))
        assert numbers[0] == last
        last = numbers[-1]
    table = getattr(frame_types()[name], "table", frame_types()[name])
    assert last == table.length


def test_examples_of_the_auv_are_its_canonical_frames() -> None:
    canonical = {(name, raw) for name, _, raw in AUV}
    extra = {(e.type, e.raw) for e in examples() if e.type.startswith("auv")} - canonical
    assert extra == {("auv.AW", b"@AW0802ZAF6$")}


def test_errata_name_types_and_tolerances_that_exist_and_each_is_named_once() -> None:
    types = set(frame_types()) | {name.partition(".")[0] for name in frame_types()}
    tolerances = {row.name for row in TOLERANCES}
    tolerances |= {key.name for row in VEHICLES.values() for key in row.keys}
    assert len({row.name for row in ERRATA}) == len(ERRATA)
    for row in ERRATA:
        assert set(row.frames) <= types, row.name
        assert {t for t in row.tolerance.split(", ") if t} <= tolerances, row.name
        assert row.finding in TEXT
        assert row.reading in TEXT
    assert [row.name for row in errata_of("robot.UP")] == ["E-P2", "E-P5", "E-P6", "E-P8", "E-P9"]


def test_every_tolerance_is_listed() -> None:
    for row in TOLERANCES:
        assert f"| `{row.name}`" in TEXT


@pytest.mark.parametrize(
    ("frame", "name", "expected"),
    [
        ("auv.SD", "roll_deg", "deg"),
        ("auv.SD", "pwm_left_main", "us"),
        ("auv.VS", "mag_front_x", "nT"),
        ("auv.MT", "gear", ""),
        ("coreboard.CAN_TORQUE", "mx_nm", "N m"),
        ("coreboard.MAIN_TO_PC", "usbl1", "deg"),
        ("robot.DOWN", "speed_mm_s", "mm/s"),
        ("gps.nmea.RMC", "speed_m_s", "m/s"),
        ("rov.UP", "rpm_left_up", "r/min"),
        ("coreboard.SENSOR_TO_MAIN", "p", ""),
    ],
)
def test_units_follow_from_the_name_or_the_frame(frame: str, name: str, expected: str) -> None:
    assert unit(frame, name) == expected
