"""Overdue: the boat knows when a vehicle had to be up, says so, and where it may be by then."""

from __future__ import annotations

import json
import math
import time
from dataclasses import replace
from itertools import count
from pathlib import Path

import pytest
from click.testing import CliRunner
from served import soon

from mission.authoring.language import script
from mission.authoring.prepare import check_prepared, prepare
from mission.cli import main
from mission.model import Position
from mission.model.plain import to_plain
from mission.navigation.geodesy import LocalFrame
from mission.topside import console
from mission.topside.contacts import Contacts
from mission.topside.dives import FILE, KEPT, SEARCHED_S, Dives, default_folder, missing
from mission.topside.monitor import Watched
from mission.topside.overdue import (
    LATE_S,
    UNSURE_M,
    Area,
    Contact,
    Dive,
    Plan,
    contact_with,
    heard,
    moment,
    overdue,
    plan_of,
    search_area,
)
from mission.topside.upload import Script
from protocol.messages import StoreReport

HOME = (30.0, 120.0)
PLAN = Plan("survey", worst_s=600.0, range_m=200.0, current=0.5, home=HOME)
DIGEST = "0123456789abcdef"
UNDER_WAY = Contact(1100.0, "autonomous", 30.001, 120.0, mission=DIGEST)
DIVE = Dive(1000.0, PLAN, UNDER_WAY, DIGEST)
URL = "tcp://vehicle:4000"
MODEM = "modem+serial:///dev/ttyUSB0?range=800&rate=600"
DECK = Contact(1050.0, "idle/ready", mission=DIGEST)


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


@pytest.mark.parametrize("state", ["autonomous", "emergency/surfacing", "emergency/stopped"])
def test_one_that_was_heard_behind_its_time_and_was_not_up_is_overdue_again(state: str) -> None:
    dive = replace(DIVE, contact=replace(UNDER_WAY, wall=1650.0, state=state))
    assert overdue(dive, 1650.0 + 599.0) == ""
    assert "to be up 11 min ago at the latest, heard 10 min ago" in overdue(dive, 1650.0 + 601.0)
    up = heard(dive, replace(UNDER_WAY, wall=1700.0, state="emergency/surfaced"))
    assert overdue(up, 9999.0) == ""


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


@pytest.mark.parametrize("home", [HOME, None])
def test_what_was_heard_before_the_start_makes_the_searched_area_no_smaller(
    home: tuple[float, float] | None,
) -> None:
    """Looked at on deck, started, and never heard again."""
    still = replace(PLAN, home=home, current=0.0)
    on_deck = replace(DECK, wall=900.0, latitude=HOME[0], longitude=HOME[1])
    area = search_area(Dive(1000.0, still, on_deck, DIGEST), 1700.0)
    assert area is not None
    assert area.short_m >= PLAN.range_m


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
    dives.uploaded(DIGEST * 4, PLAN)
    dives.started(URL, DIGEST, 1000.0)
    dives.contact(URL, UNDER_WAY)
    assert Dives(tmp_path).of(URL) == DIVE
    dives.contact(URL, replace(UNDER_WAY, wall=1150.0, state="manual/waiting"))
    dives.started(URL, DIGEST, 1200.0)
    assert dives.of(URL).started == 1000.0, "a mission that goes on has begun before"
    dives.contact(URL, replace(UNDER_WAY, wall=1300.0, state="emergency/surfaced"))
    assert dives.of(URL).due is None
    assert dives.of("tcp://other:4000") == Dive()


def started(folder: Path, *urls: str) -> Dives:
    dives = Dives(folder)
    dives.uploaded(DIGEST * 4, PLAN)
    for url in urls:
        dives.started(url, DIGEST, 1000.0)
    return dives


def told(dives: Dives, url: str, now: float = 1660.0) -> str:
    return missing(dives.missed(url, now), url, now)


def test_a_start_by_one_way_is_overdue_on_a_way_on_which_nobody_ever_answered(
    tmp_path: Path,
) -> None:
    dives = started(tmp_path, URL)
    assert told(dives, MODEM, 1500.0) == ""
    assert told(dives, URL).startswith("it was to be up 60 s ago")
    words = told(dives, MODEM)
    assert words.startswith("survey, known by tcp://vehicle:4000: it was to be up 60 s ago")
    assert "search within 230 m of" in words


def test_who_answers_under_way_with_the_mission_is_the_same_vehicle_by_all_ways(
    tmp_path: Path,
) -> None:
    dives = started(tmp_path, URL)
    dives.contact(MODEM, replace(UNDER_WAY, wall=1300.0))
    for url in (URL, MODEM, "modem+serial:///dev/ttyUSB0?rate=300"):
        assert dives.of(url).contact == replace(UNDER_WAY, wall=1300.0)
        assert "heard 6 min ago; search" in told(dives, url)
    dives.contact(MODEM, replace(UNDER_WAY, wall=1601.0))
    assert (told(dives, URL), told(dives, MODEM)) == ("", "")
    dives.contact(MODEM, replace(DECK, wall=1700.0))
    assert (dives.of(URL).due, dives.of(MODEM).due) == (None, None)


def test_what_was_heard_before_by_another_way_is_not_kept_in_place_of_the_last(
    tmp_path: Path,
) -> None:
    """Two that look by two ways keep what each heard last, again and again."""
    dives = started(tmp_path, URL)
    last = replace(UNDER_WAY, wall=1300.0, current=(0.1, 0.0))
    for _ in range(2):
        dives.contact(URL, last)
        dives.contact(MODEM, replace(UNDER_WAY, wall=1290.0))
        assert dives.of(MODEM).contact == dives.of(URL).contact == last


def test_a_vehicle_on_deck_with_the_same_mission_ends_no_dive_of_another(tmp_path: Path) -> None:
    dives = started(tmp_path, URL)
    dives.contact("tcp://other:4000", DECK)
    assert "search" in told(dives, URL)
    assert dives.of(URL).contact is None


def test_of_two_that_fly_one_mission_neither_is_taken_for_the_other(tmp_path: Path) -> None:
    dives = started(tmp_path, URL, "tcp://other:4000")
    dives.contact(MODEM, replace(UNDER_WAY, wall=1650.0))
    assert told(dives, URL)
    assert told(dives, "tcp://other:4000")
    elsewhere = replace(UNDER_WAY, began=500.0)
    one = started(tmp_path / "one", URL)
    one.contact(MODEM, elsewhere)
    assert one.of(URL).contact is None, "that one began at another time"


def test_another_mission_by_that_way_is_another_vehicle(tmp_path: Path) -> None:
    dives = started(tmp_path, URL)
    dives.contact(MODEM, UNDER_WAY)
    dives.contact(MODEM, Contact(1200.0, "idle/ready", mission="fedcba9876543210"))
    assert dives.of(URL) == DIVE
    assert dives.of(MODEM).started is None


def test_another_mission_at_the_own_address_ends_the_dive(tmp_path: Path) -> None:
    dives = started(tmp_path, URL)
    dives.contact(URL, Contact(1200.0, "autonomous", mission="fedcba9876543210"))
    assert told(dives, URL) == ""


def test_who_is_known_to_be_under_way_there_is_asked_for_and_nobody_else(tmp_path: Path) -> None:
    dives = started(tmp_path, URL)
    dives.started("tcp://other:4000", DIGEST, 1500.0)
    assert told(dives, "tcp://other:4000") == ""
    assert told(dives, MODEM).count("known by") == 1
    assert told(dives, MODEM, 2200.0).count("known by") == 2


def test_a_dive_of_days_ago_is_told_by_its_own_way_alone(tmp_path: Path) -> None:
    dives, late = started(tmp_path, URL), 1601.0 + SEARCHED_S
    assert told(dives, URL, late)
    assert told(dives, MODEM, late) == ""


def test_what_came_before_the_start_ends_no_dive(tmp_path: Path) -> None:
    dives = started(tmp_path, URL)
    dives.contact(URL, replace(DECK, wall=999.0))
    assert dives.of(URL).started == 1000.0


def test_a_dive_that_somebody_else_started_is_known_when_it_was_heard_twice(
    tmp_path: Path,
) -> None:
    dives = Dives(tmp_path)
    dives.uploaded(DIGEST, PLAN)
    dives.contact(URL, UNDER_WAY)
    assert dives.of(URL).started is None
    dives.contact(URL, replace(UNDER_WAY, wall=1110.0))
    assert dives.of(URL).started == 1100.0
    assert told(dives, MODEM, 1100.0 + 660.0)


def test_a_dive_that_tells_when_it_began_is_known_at_once(tmp_path: Path) -> None:
    dives = Dives(tmp_path)
    dives.uploaded(DIGEST, PLAN)
    dives.contact(URL, replace(UNDER_WAY, began=1080.0))
    assert dives.of(URL).started == 1080.0
    assert told(dives, MODEM, 1080.0 + 660.0)


@pytest.mark.parametrize("late", [DECK, Contact(0.0, "autonomous", mission="fedcba9876543210")])
def test_what_was_told_before_the_start_and_comes_just_behind_it_ends_no_dive(
    tmp_path: Path, late: Contact
) -> None:
    dives = started(tmp_path, URL)
    dives.contact(URL, replace(late, wall=1000.0 + LATE_S - 0.1))
    assert dives.of(URL) == Dive(1000.0, PLAN, None, DIGEST)
    dives.contact(URL, replace(late, wall=1000.0 + LATE_S))
    assert dives.of(URL).due is None


@pytest.mark.parametrize("before", [None, UNDER_WAY, replace(DECK, wall=1050.0)])
def test_a_second_start_is_a_dive_of_its_own_where_no_stick_was_heard_since(
    tmp_path: Path, before: Contact | None
) -> None:
    dives = Dives(tmp_path)
    dives.contact(URL, replace(UNDER_WAY, wall=990.0, state="manual/driving"))
    dives = started(tmp_path, URL)
    if before is not None:
        dives.contact(URL, before)
    dives.started(URL, DIGEST, 1400.0)
    assert dives.of(URL).due == 1400.0 + PLAN.worst_s


def test_a_start_after_the_due_time_is_a_dive_of_its_own(tmp_path: Path) -> None:
    dives = started(tmp_path, URL)
    dives.started(URL, DIGEST, 90_000.0)
    assert dives.of(URL).started == 90_000.0


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


# --- where it is told ----------------------------------------------------------------------------

SILENT = {"the way it was started by": "tcp://127.0.0.1:1", "a modem": "modem+tcp://127.0.0.1:1"}


def long_ago(folder: Path) -> None:
    """A dive that was started by another way, or that one, a day ago."""
    dives = Dives(folder)
    dives.uploaded(DIGEST, PLAN)
    dives.started(SILENT["the way it was started by"], DIGEST, time.time() - 86_400.0)


@pytest.mark.parametrize("way", SILENT)
def test_status_says_so_by_every_way(
    way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    long_ago(default_folder())
    people, data = (
        CliRunner().invoke(main, ["status", "--to", SILENT[way], *more])
        for more in ([], ["--json"])
    )
    assert (people.exit_code, data.exit_code) == (1, 1)
    assert "ALARM OVERDUE" in people.stdout
    named = {alarm["name"]: alarm["words"] for alarm in json.loads(data.stdout)["alarms"]}
    assert "search within" in named["OVERDUE"]
    assert ("known by tcp://127.0.0.1:1" in named["OVERDUE"]) == (way == "a modem")


def test_the_command_start_notes_a_start_that_nobody_answered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def converse(url: str, talk: Script) -> str:
        next(talk)
        talk.send(StoreReport("ready", 3, 3, "", DIGEST, ""))
        talk.send(None)
        raise AssertionError

    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setattr(console, "converse", converse)
    Dives(default_folder()).uploaded(DIGEST, PLAN)
    ran = CliRunner().invoke(main, ["start", "--to", URL])
    assert ran.exit_code == 1
    assert "whether the mission started is not known" in ran.stderr
    assert Dives(default_folder()).of(URL).due is not None


@pytest.mark.parametrize("way", SILENT)
def test_watch_and_console_say_so_by_every_way(way: str, tmp_path: Path) -> None:
    long_ago(tmp_path)
    (alarm,) = Contacts(SILENT[way], tmp_path).alarms(Watched(), 0.0, True)
    assert alarm.name == "OVERDUE"
    assert "search within" in alarm.words


@pytest.mark.parametrize("way", SILENT)
def test_a_silence_before_its_time_says_when_it_will_be_up(
    way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By both ways, once one vehicle was heard by both."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    url, now = SILENT["the way it was started by"], time.time()
    dives = Dives(default_folder())
    dives.uploaded(DIGEST, PLAN)
    dives.started(url, DIGEST, now - 60.0)
    dives.contact(SILENT["a modem"], replace(UNDER_WAY, wall=now - 30.0))
    asked = ["status", "--to", SILENT[way]]
    people, data = (CliRunner().invoke(main, [*asked, *more]) for more in ([], ["--json"]))
    due = dives.of(url).due
    assert due is not None
    clock, _, _ = moment(due, now).partition(", ")
    assert f"{'up by':12} {clock}, in " in people.stdout
    told = json.loads(data.stdout)
    assert told["up_by"] == due
    assert [alarm["name"] for alarm in told["alarms"]] == ["no contact"]


def test_a_simulated_vehicle_is_never_missed(tmp_path: Path) -> None:
    long_ago(tmp_path)
    boat = Contacts("", tmp_path)
    boat.started(DIGEST)
    assert boat.alarms(Watched(), 0.0, True) == ()
    assert boat.due() is None


def test_what_is_proved_of_a_mission_is_learned_from_the_vehicle_that_flies_it(
    tmp_path: Path,
) -> None:
    known, boat = Watched(), Contacts(URL, tmp_path)
    prepared = prepare("first-dive")
    digest, lines = prepared.chart.digest[:16], script(prepared.mission)
    state = {"state": "autonomous/dive", "mission": digest, "mission_began": 10.0}
    known.take({"n": 1, "t": 70.0, "state": state, "plan": ["", *lines[:3]]}, 0.0)
    boat.remember(known, 0.0)
    known.take({"n": 2, "t": 90.0, "state": state, "plan": lines[3:]}, 20.0)

    proved = check_prepared(prepared).proved
    assert proved is not None
    looks = count(20.0, 11.0)

    def is_noted() -> bool:
        boat.remember(known, next(looks))
        return boat.due() is not None

    soon(is_noted, "the worst time is known")
    assert boat.dives.of(URL).plan == plan_of(prepared, proved)
