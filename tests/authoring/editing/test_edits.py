"""An edit of the chart changes the numbers of its place, or one line, and nothing else."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import pytest

from mission.authoring.editing.edits import add, move, remove
from mission.authoring.editing.handles import Handle, handles
from mission.authoring.editing.layout import EditError
from mission.authoring.language import draft, parse
from mission.model.shipped import missions_folder

SHIPPED = sorted(
    path for path in missions_folder().rglob("*") if path.suffix in (".yaml", ".mission")
    and "vehicles" not in path.parts
)  # fmt: skip
HOME = (30.2874595, 120.1535765)
YAML = """\
# Ä line that an edit must not touch: 30.2874595
mission: tour
home: {latitude: 30.2874595, longitude: 120.1535765}   # the quay
safety: {radius: 900 m, time: 40 min, depth: 12 m, voltage: 10 V}
param: {far: 120 m}
legs:
  - out: {goto: {north: 60 m, east: -0.05 km}, within: 15 m, gear: 8, depth: 3 m, timeout: 4 min}  # away
  - named: {goto: {north: far, east: 5 m}, within: 15 m, gear: 8, depth: 3 m, timeout: 6 min}
  - round:
      follow: [{north: 10 m, east: 20 m}, north 30.25 east 40, {latitude: 30.288, longitude: 120.154}]
      gear: 8
      depth: 3 m
      timeout: 9 min
  - blocks:
      follow:
        - {north: 1 m, east: 2 m}   # first
        - north 3 east 4
      gear: 8
      depth: 3 m
      timeout: 9 min
  - up: {surface: true, until: fix, timeout: 3 min}
"""
LINES = """\
mission tour    # north 60 east -50
home 30.2874595, 120.1535765
safety radius 900 time 40min depth 12 voltage 10
keep out rocks: north 200 east 0, north 250 east 0, north 250 east 50, north 220 east 70 between 0 and 4
out: goto north 60 east -50
 + within 15 gear 8 depth 3   # ö north 60
 + timeout 4min
round: follow north 10 m east 20, 30.288 120.154, north 50 east 60 gear 8 depth 3 timeout 9min
up: surface until fix timeout 3min
"""
BOTH = {"t.yaml": YAML, "t.mission": LINES}


def known(text: str, source: str) -> tuple[Handle, ...]:
    return handles(draft(text, source), text)


def at(handle: Handle) -> tuple[float, float]:
    assert handle.position is not None
    return handle.position


def off(place: tuple[float, float], north: float, east: float) -> tuple[float, float]:
    turn = east / 111_000.0 / math.cos(math.radians(place[0]))
    return place[0] + north / 111_000.0, place[1] + turn


def named(text: str, source: str, path: str, row: int = 0) -> int:
    found = known(text, source)
    return next(i for i, h in enumerate(found) if h.path == path and h.at == row)


def movable() -> Iterator[tuple[str, str, int]]:
    texts = {path.name: path.read_text(encoding="utf-8") for path in SHIPPED}
    for source, text in (texts | BOTH).items():
        for index, handle in enumerate(known(text, source)):
            if not handle.fixed:
                yield source, text, index


@pytest.mark.parametrize(("source", "text", "index"), list(movable()))
def test_a_place_that_is_moved_and_moved_back_leaves_the_same_bytes(
    source: str, text: str, index: int
) -> None:
    place = at(known(text, source)[index])
    away = move(text, source, index, off(place, 33.3, -44.4))
    assert away != text
    assert move(away, source, index, place) == text


@pytest.mark.parametrize(("source", "text", "index"), list(movable()))
def test_a_move_changes_the_numbers_of_its_place_alone(source: str, text: str, index: int) -> None:
    one = known(text, source)[index]
    away = move(text, source, index, off(at(one), 33.3, -44.4))
    without = [re.sub(r"-?\d+(\.\d+)?", "#", t) for t in (text, away)]
    assert without[0] == without[1]
    changed = [n for n, rows in enumerate(zip(text.split("\n"), away.split("\n"), strict=True), 1)
               if rows[0] != rows[1]]  # fmt: skip
    assert set(changed) <= {amount.where.line for amount in one.numbers}


def test_a_move_is_where_it_was_wanted_to_a_decimetre() -> None:
    for source, text in BOTH.items():
        index = named(text, source, "out")
        to = off(HOME, 71.23, 12.34)
        found = at(known(move(text, source, index, to), source)[index])
        assert math.dist(found, to) * 111_000 < 0.1


def test_a_unit_is_kept_and_so_is_a_number_that_does_not_change() -> None:
    index = named(YAML, "t.yaml", "out")
    moved = move(YAML, "t.yaml", index, off(at(known(YAML, "t.yaml")[index]), 20.0, 0.0))
    assert "east: -0.05 km}" in moved
    assert "north: 60 m" not in moved


def test_a_number_that_does_not_change_stays_as_it_is_written() -> None:
    text = LINES.replace("north 60 east -50", "north 60.0 east -5e1")
    index = named(text, "t.mission", "out")
    place = at(known(text, "t.mission")[index])
    assert move(text, "t.mission", index, place) == text
    moved = move(text, "t.mission", index, off(place, 20.0, 0.0))
    assert "east -5e1" in moved
    assert "north 60" not in moved.split("\n")[4]


def test_a_place_in_the_first_line_is_found_behind_a_byte_order_mark() -> None:
    text = f"\ufeffhome {HOME[0]} {HOME[1]}\nwait 1s\n"
    assert move(text, "t.mission", 0, (30.5, 120.5)) == "\ufeffhome 30.5 120.5\nwait 1s\n"


def test_a_leg_whose_copy_would_lead_to_another_group_is_written_anew() -> None:
    text = (missions_folder() / "transect.yaml").read_text(encoding="utf-8")
    grown = add(text, "transect.yaml", "goto", off(HOME, 50.0, 50.0))
    assert parse(grown).body[-2].name == "goto_1"


def test_a_place_that_a_parameter_sets_is_shown_and_stays() -> None:
    index = named(YAML, "t.yaml", "named")
    one = known(YAML, "t.yaml")[index]
    assert math.dist(at(one), off(HOME, 120.0, 5.0)) * 111_000 < 1.0
    with pytest.raises(EditError, match="far"):
        move(YAML, "t.yaml", index, HOME)


def test_the_same_place_by_an_alias_is_one_place() -> None:
    text = YAML.replace("{goto: {north: 60 m", "{goto: &p {north: 60 m").replace(
        "{goto: {north: far, east: 5 m}", "{goto: *p"
    )
    paths = [handle.path for handle in known(text, "t.yaml")]
    assert "out" in paths
    assert "named" not in paths


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_lines_that_end_as_on_windows_and_a_byte_order_mark_are_kept(
    newline: str, mark: str
) -> None:
    for source, text in BOTH.items():
        given = mark + text.replace("\n", newline)
        index = named(given, source, "home")
        home = at(known(given, source)[index])
        away = move(given, source, index, off(home, 30.0, 30.0))
        assert move(away, source, index, home) == given
        grown = add(given, source, "goto", off(HOME, 50.0, 50.0))
        assert grown.count("\n") == grown.count(newline) > given.count(newline)


@pytest.mark.parametrize("source", BOTH)
@pytest.mark.parametrize("path", ["round", "blocks", "rocks"])
def test_a_place_that_is_added_to_a_row_and_removed_leaves_the_same_bytes(
    source: str, path: str
) -> None:
    text = BOTH[source]
    count = sum(handle.path == path for handle in known(text, source))
    for row in range(count):
        index = named(text, source, path, row)
        to = off(HOME, 77.0, 78.0)
        grown = add(text, source, "point", to, index)
        assert sum(handle.path == path for handle in known(grown, source)) == count + 1
        new = named(grown, source, path, row + 1)
        assert math.dist(at(known(grown, source)[new]), to) * 111_000 < 0.1
        assert remove(grown, source, new) == text


@pytest.mark.parametrize("source", BOTH)
@pytest.mark.parametrize("what", ["goto", "rows", "loiter"])
@pytest.mark.parametrize("behind", [None, "out", "round"])
def test_a_leg_that_is_added_and_removed_leaves_the_same_bytes(
    source: str, what: str, behind: str | None
) -> None:
    text = BOTH[source]
    after = None if behind is None else named(text, source, behind)
    grown = add(text, source, what, off(HOME, 50.0, 70.0), after)
    fresh = [h for h in known(grown, source) if h.path == f"{what}_1"]
    assert len(fresh) == 1
    assert remove(grown, source, known(grown, source).index(fresh[0])) == text
    legs = [leg.name for leg in parse(grown, source).body]
    assert legs.index(f"{what}_1") == (len(legs) - 2 if behind is None else legs.index(behind) + 1)


def test_a_leg_is_added_as_the_mission_writes_them() -> None:
    to = off(HOME, 61.0, 0.0)
    line = "  - goto_1: {goto: {north: 60.9 m, east: 0 km}, within: 15 m, gear: 8, depth: 3 m, timeout: 4 min}"
    assert line in add(YAML, "t.yaml", "goto", to, named(YAML, "t.yaml", "out")).split("\n")


def test_a_leg_that_is_far_off_gets_the_time_it_needs() -> None:
    grown = add(YAML, "t.yaml", "goto", off(HOME, 800.0, 0.0))
    line = next(line for line in grown.split("\n") if "goto_1" in line)
    minutes = int(re.findall(r"timeout: (\d+) min", line)[0])
    assert minutes > 15


@pytest.mark.parametrize("source", BOTH)
@pytest.mark.parametrize("what", ["keep_out", "keep_in"])
def test_an_area_is_added_around_the_place(source: str, what: str) -> None:
    grown = add(BOTH[source], source, what, off(HOME, 50.0, 70.0))
    area = next(a for a in parse(grown, source).areas if a.name == "area_1")
    assert (len(area.corners), area.out) == (4, what == "keep_out")
    again = add(grown, source, what, off(HOME, 150.0, 70.0))
    assert len(parse(again, source).areas) == len(parse(grown, source).areas) + 1


def test_an_area_finds_its_place_in_tables_of_lines_too() -> None:
    text = YAML.replace(
        "safety: {radius: 900 m, time: 40 min, depth: 12 m, voltage: 10 V}",
        "safety:\n  radius: 900 m\n  time: 40 min",
    )
    grown = add(text, "t.yaml", "keep_out", HOME)
    assert [area.name for area in parse(grown).areas] == ["area_1"]
    bare = text.replace("safety:\n  radius: 900 m\n  time: 40 min\n", "")
    assert [area.name for area in parse(add(bare, "t.yaml", "keep_out", HOME)).areas] == ["area_1"]


@pytest.mark.parametrize(
    ("text", "do", "says"),
    [
        (YAML, lambda t: remove(t, "t.yaml", 0), "home cannot be removed"),
        (YAML, lambda t: remove(t, "t.yaml", named(t, "t.yaml", "blocks")), "2 places"),
        (YAML, lambda t: move(t, "t.yaml", 99, HOME), "no such place"),
        (YAML, lambda t: move(t, "t.yaml", 1, (91.0, 0.0)), "latitude"),
        (YAML, lambda t: move(t, "t.yaml", 1, (31.0, 120.0)), "20 km"),
        (YAML, lambda t: add(t, "t.yaml", "castle", HOME), "castle"),
        (YAML, lambda t: add(t, "t.yaml", "point", HOME, 1), "row of places"),
        (YAML + "  - bad: {}\n", lambda t: add(t, "t.yaml", "goto", HOME), "mend line"),
        (LINES, lambda t: remove(t, "t.mission", len(known(t, "t.mission"))), "no such place"),
    ],
)
def test_what_cannot_be_done_is_refused_with_the_reason(text: str, do, says: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(EditError, match=says):
        do(text)


def test_an_area_keeps_three_corners() -> None:
    text = remove(LINES, "t.mission", named(LINES, "t.mission", "rocks", 3))
    with pytest.raises(EditError, match="3 corners"):
        remove(text, "t.mission", named(text, "t.mission", "rocks"))


def test_the_places_of_a_text_with_an_error_elsewhere_can_be_moved() -> None:
    text = YAML.replace("surface: true", "surfaec: true")
    index = named(text, "t.yaml", "out")
    moved = move(text, "t.yaml", index, off(HOME, 70.0, 0.0))
    assert "surfaec" in moved


@pytest.mark.proof
def test_a_mission_of_the_greatest_length_is_edited() -> None:
    waits = "".join(f"w{i}: wait 1s\n" for i in range(9_990))
    far = "far: goto north 5 east 5 within 15 gear 8 timeout 60s\nup: surface timeout 60s\n"
    text = f"mission long\nhome {HOME[0]} {HOME[1]}\n{waits}{far}"
    moved = move(text, "t.mission", 1, off(HOME, 50.0, 5.0))
    assert moved == text.replace("north 5 east 5", "north 49.9 east 5")


def test_a_text_beyond_every_limit_is_refused_and_not_edited() -> None:
    for text in ("wait 1s\n" * 10_001, "x" * (1 << 20), "- [" * 10_000):
        with pytest.raises(EditError):
            add(text, "t.yaml", "goto", HOME)
