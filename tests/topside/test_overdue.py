"""Overdue: the boat knows when a vehicle had to be up, says so, and where it may be by then."""

from __future__ import annotations

import json
import math
import time
from dataclasses import replace
from pathlib import Path

import pytest

from mission.model import Position
from mission.model.plain import to_plain
from mission.navigation.geodesy import LocalFrame
from mission.topside.contacts import Contacts
from mission.topside.dives import FILE, KEPT, Dives
from mission.topside.monitor import Watched
from mission.topside.overdue import (
    UNSURE_M,
    Area,
    Contact,
    Dive,
    Plan,
    contact_with,
    overdue,
    search_area,
)

HOME = (30.0, 120.0)
PLAN = Plan("survey", worst_s=600.0, range_m=200.0, current=0.5, home=HOME)
UNDER_WAY = Contact(1100.0, "autonomous", 30.001, 120.0)
DIVE = Dive(1000.0, PLAN, UNDER_WAY)
URL = "tcp://vehicle:4000"


def offset(area: Area | None) -> tuple[float, float]:
    """m north and east of home."""
    assert area is not None
    frame = LocalFrame(Position(*HOME))
    return frame.to_local(math.radians(area.latitude), math.radians(area.longitude))


def test_it_is_overdue_when_the_proved_time_has_passed_without_a_contact() -> None:
    assert overdue(DIVE, 1600.0) == ""
    words = overdue(DIVE, 1660.0)
    assert "to be up 60 s ago" in words
    assert "heard 9 min ago" in words
    assert "search within" in words


@pytest.mark.parametrize(
    "dive",
    [
        replace(DIVE, started=None),
        replace(DIVE, plan=None),
        replace(DIVE, contact=replace(UNDER_WAY, wall=1601.0)),
        Dive(),
    ],
)
def test_it_is_not_overdue_where_nothing_is_due_or_it_was_heard_since(dive: Dive) -> None:
    assert overdue(dive, 1660.0) == ""


def test_one_that_was_under_way_is_searched_around_home_and_farther_with_the_sea() -> None:
    early, late = search_area(DIVE, 1300.0), search_area(DIVE, 1700.0)
    assert early is not None
    assert late is not None
    assert offset(early) == pytest.approx((0.0, 0.0), abs=0.01)
    assert early.long_m == 200.0, "by proof, while it is not due"
    assert late.long_m == 200.0 + 0.5 * 100.0, "then the sea takes it along"


def test_without_a_home_it_is_searched_around_the_contact() -> None:
    dive = replace(DIVE, plan=replace(PLAN, home=None))
    area = search_area(dive, 1200.0)
    assert area is not None
    assert offset(area)[0] == pytest.approx(110.9, abs=0.2)
    assert area.long_m == 2 * 200.0 + 0.5 * 100.0


def test_one_that_drifted_is_searched_in_an_ellipse_that_moves_and_grows() -> None:
    drifting = Contact(1100.0, "emergency/stopped", *HOME, (100.0, 0.0, 25.0), (0.0, 0.2))
    first, then = (search_area(replace(DIVE, contact=drifting), t) for t in (1100.0, 1200.0))
    assert first is not None
    assert then is not None
    assert offset(then) == pytest.approx((0.0, 20.0), abs=0.01), "with the current it knew"
    assert (first.long_m, first.short_m) == pytest.approx((24.48, 12.24), abs=0.01)
    assert (then.long_m - first.long_m, then.short_m - first.short_m) == pytest.approx((50.0, 50.0))
    assert first.bearing == 0.0
    assert "000 and 180 deg" in str(then)


def test_a_fix_of_unknown_accuracy_counts_as_unsure() -> None:
    area = search_area(replace(DIVE, contact=replace(UNDER_WAY, state="emergency/stopped")), 1100.0)
    assert area is not None
    assert area.long_m == UNSURE_M


def test_what_a_monitor_tells_is_kept_with_its_ellipse_and_current() -> None:
    state = {"state": "emergency/stopped", "latitude": HOME[0], "longitude": HOME[1],
             "ellipse": [24.48, 12.24, 30], "current": [0.1, 0.2]}  # fmt: skip
    area = search_area(replace(DIVE, contact=contact_with(state, 1100.0)), 1100.0)
    assert area is not None
    assert (area.long_m, area.short_m, area.bearing) == pytest.approx(
        (24.48, 12.24, 30.0), abs=0.01
    )
    assert contact_with(state, 1100.0).current == (0.1, 0.2)
    bare = contact_with({}, 5.0)
    assert (bare.state, bare.latitude, bare.covariance) == ("autonomous", None, None)


def test_where_no_place_was_ever_known_that_is_said() -> None:
    dive = replace(DIVE, plan=replace(PLAN, home=None), contact=None)
    assert "nobody knows where" in overdue(dive, 1660.0)
    assert "heard never" in overdue(dive, 1660.0)


def test_the_boat_remembers_from_the_upload_to_the_end_of_the_dive(tmp_path: Path) -> None:
    dives = Dives(tmp_path)
    dives.uploaded("0123456789abcdef" * 4, PLAN)
    dives.started(URL, "0123456789abcdef", 1000.0)
    dives.contact(URL, UNDER_WAY)
    assert Dives(tmp_path).of(URL) == DIVE
    dives.started(URL, "0123456789abcdef", 1200.0)
    assert dives.of(URL).started == 1000.0, "a mission that goes on has begun before"
    dives.contact(URL, replace(UNDER_WAY, wall=1300.0, state="emergency/surfaced"))
    assert dives.of(URL).due is None
    assert dives.of("tcp://other:4000") == Dive()


def test_a_mission_that_was_not_uploaded_from_here_has_no_due_time(tmp_path: Path) -> None:
    dives = Dives(tmp_path)
    dives.started(URL, "fedcba9876543210", 1000.0)
    assert dives.of(URL).due is None


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"boats": 3}', '{"boats": {"tcp://vehicle:4000": [1]}}']
)
def test_a_broken_file_costs_no_command(tmp_path: Path, text: str) -> None:
    (tmp_path / FILE).write_text(text)
    dives = Dives(tmp_path)
    assert dives.of(URL) == Dive()
    dives.contact(URL, UNDER_WAY)
    assert dives.of(URL).contact == UNDER_WAY


def test_a_folder_that_cannot_be_written_costs_no_command(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    Dives(tmp_path / "file").contact(URL, UNDER_WAY)
    assert Dives(tmp_path / "file").of(URL) == Dive()


def test_the_file_does_not_grow_for_ever(tmp_path: Path) -> None:
    dives = Dives(tmp_path)
    for number in range(KEPT + 5):
        dives.contact(f"tcp://v{number}:4000", UNDER_WAY)
    assert dives.of("tcp://v0:4000") == Dive()
    assert dives.of(f"tcp://v{KEPT + 4}:4000").contact == UNDER_WAY


def test_overdue_ends_with_the_first_frame_that_comes_and_not_when_it_is_next_kept(
    tmp_path: Path,
) -> None:
    wall = time.time()
    late = Dive(wall - 1000.0, PLAN, replace(UNDER_WAY, wall=wall - 900.0))
    file = {"plans": {}, "boats": {URL: to_plain(late)}}
    (tmp_path / FILE).write_text(json.dumps(file), encoding="utf-8")
    boat, known = Contacts(URL, tmp_path), Watched()
    assert [alarm.name for alarm in boat.alarms(known, 0.0, True)] == ["OVERDUE"]
    known.take({"n": 1, "t": 900.0, "state": {"state": "autonomous/out"}}, 1.0)
    assert boat.alarms(known, 1.5, True) == ()
    gone = [alarm.name for alarm in boat.alarms(known, 60.0, True)]
    assert gone == ["no contact", "OVERDUE"]
