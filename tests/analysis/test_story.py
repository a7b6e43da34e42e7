"""Laws of log and story: who was not there is told what happened, whole and in order."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from links.base import Rx
from links.simulated.settings import parse_settings
from mission.analysis.chapters import Chapter, Table
from mission.analysis.doubts import Spell, summed
from mission.analysis.journal import Wanted, follow, lines, recordings, restart
from mission.analysis.lastly import Lastly
from mission.analysis.repeats import Again, Commands, Refusals, Rows, Words
from mission.analysis.resting import Sunk, Unfixed
from mission.analysis.story import Teller, between, story
from mission.analysis.tell import as_html, as_markdown, as_text
from mission.analysis.turned import Turned
from mission.analysis.unsaid import Absence, Power, Unsaid
from mission.authoring.prepare import prepare
from mission.commands.log import log
from mission.commands.story import story as story_command
from mission.model import Position, Record, Step, Tx
from mission.model.shown import clock
from mission.navigation.geodesy import LocalFrame
from mission.onboard.blackbox import BlackBox, Gap, close_part
from mission.onboard.runtime.records import ListRecorder, input_record, rx_record, tx_record
from mission.onboard.stream.derived import Message
from mission.onboard.stream.events import events_of
from mission.onboard.stream.topics import AID, FIX, STATE, TELEMETRY
from mission.verification.simulation.flight import fly

RECORDED = Path(__file__).parent / "recorded"
SHORT, HEAVY, AGAIN = (
    RECORDED / f"{name}.mcap" for name in ("short-time", "heavy-then-ended", "begun-again")
)


def logged(*words: str | Path) -> Result:
    return CliRunner().invoke(log, list(map(str, words)))


def told(*paths: Path) -> str:
    return as_text("dive", story(recordings(paths)))


def chapter(chapters: list[Chapter], title: str) -> Table:
    (found,) = [one for one in chapters if one.title == title]
    return found.tables[0]


def test_every_command_that_left_stands_in_the_story_with_its_reason() -> None:
    (items,) = recordings([SHORT])
    sent = [
        one
        for one in items
        if isinstance(one, Record) and one.kind == "tx" and b'"vehicle"' in one.payload
    ]
    rows = chapter(story([items]), "Commands to the vehicle").rows
    words = [json.loads(record.payload) for record in sent]
    news = [said for said in words if not said["reason"].endswith(" (held)")]
    assert len(rows) == len(news) > 5
    for row, said in zip(rows, news, strict=True):
        times = row[2].removeprefix(said["reason"])
        assert (row[1], bool(said["reason"])) == (said["data"], True)
        assert times == "" or (said["data"] == "@ZAU12$" and times.startswith(" (2 times, until "))
    assert sum(row[2].count(" (2 times, until ") for row in rows) == len(words) - len(news)


def test_every_leg_has_the_guard_that_ended_it_and_what_it_saw() -> None:
    chapters = story(recordings([SHORT]))
    legs = chapter(chapters, "Legs").rows
    assert len(legs) > 1
    assert all(because for *_, because in legs)
    assert any(re.search(r"[<>]=? .*\(\w+ [\d.]+", because) for *_, because in legs), legs


def test_an_emergency_is_told_with_the_limit_that_began_it() -> None:
    text = told(SHORT)
    assert re.search(r"emergency, now emergency/surfacing: limit time", text), text
    assert "Alarms\n------\nat " in text
    assert re.search(r"engine +now emergency/surfacing: limit time", text), text


def with_step(changed: str, **fields: object) -> list[Record | Gap]:
    """SHORT, with other fields in the step that was taken by that trigger."""
    (items,) = recordings([SHORT])
    found: list[Record | Gap] = []
    for one in items:
        plain = json.loads(one.payload) if getattr(one, "kind", "") == "step" else {}
        if isinstance(one, Record) and plain.get("trigger") == changed:
            one = replace(one, payload=json.dumps(plain | fields).encode())
        found.append(one)
    return found


def test_a_limit_is_told_by_its_name_and_not_by_what_came_in_when_it_acted() -> None:
    """An ascent was under way, so that nothing was sent; the event is a report, and no report was
    missing."""
    seen = [["limit depth", True, [["depth", 31.749]]]]
    items = with_step("limit", event="telemetry", actions=[], evaluations=seen)
    chapters = story([items])
    why = "limit depth: the depth in force, and 1 m (depth 31.7 m)"
    assert any(f"now emergency/surfacing: {why}." in line for line in chapters[0].says)
    assert chapter(chapters, "Legs").rows[-1][3] == why
    engine = [row[2] for row in chapter(chapters, "Alarms").rows if row[1] == "engine"]
    assert f"now emergency/surfacing: {why}" in engine
    assert "telemetry" not in as_text("dive", chapters)
    (line,) = [str(line) for line in lines(items, Wanted()) if "surfacing" in str(line)]
    assert line.endswith(f"now emergency/surfacing: {why}")


def test_an_ascent_that_stays_pushed_up_at_the_surface_is_told_as_held_up() -> None:
    """It sank when it was let go: nothing is sent, and the event is only a timer."""
    items = with_step("surfaced", event="timer", actions=[])
    text = as_text("dive", story([items]))
    held = "now emergency/surfaced: the surface is reached; it sank when it was let go, so it is held up by upward thrust"
    assert f"emergency, {held}, proved by a depth that stayed shallow." in text
    assert "surfaced, timer" not in text
    assert any(held in str(line) for line in lines(items, Wanted()))


def flown(*settings: str) -> list[Record]:
    prepared, recorder = prepare(Path("first-dive")), ListRecorder()
    fly(prepared.mission, prepared.vehicle, "", 3, parse_settings(settings), recorder)
    return recorder.records


def test_a_refused_leg_is_told_as_cut_short_with_the_word_and_what_was_never_flown() -> None:
    chapters = story([flown("fault=refuses@30+200")])
    text = as_text("dive", chapters)
    assert "box/east was cut short, then surface: the vehicle refused @ZAS5$." in text
    assert "never flown: box/south, box/west, up." in text
    assert chapter(chapters, "Refusals").rows[0][1:3] == ("@ZAS5$", "the vehicle answered N")
    assert "There was none." in text, "at the beginning nobody has heard of the vehicle: no alarm"


def test_a_limit_that_leads_to_words_alone_is_told() -> None:
    text = as_text("dive", story([flown("fault=stm32_restart@40")]))
    assert "limit brown-out: all thrusters neutral while thrust is set; said again: surge" in text
    assert "limit  brown-out is breached: all thrusters neutral while thrust is set" in text
    assert "never flown" not in text


def test_the_depth_of_an_emergency_counts() -> None:
    records = flown("fault=heavy=30@60")
    depths = [
        json.loads(record.payload)["depth"] or 0.0
        for record in records
        if record.kind == "estimate"
    ]
    found = re.search(r"it was ([\d.]+) m deep at most", as_text("dive", story([records])))
    assert found is not None
    deepest = float(found[1])
    assert deepest == pytest.approx(max(depths), abs=0.2), "reports and their estimate"
    left = next(row for row in chapter(story([records]), "Limits").rows if row[0] == "depth")
    assert left[2] == f"{10.0 - deepest:.1f} m"


@pytest.fixture(scope="module")
def frozen() -> list[Record]:
    """Its depth freezes, it answers no U, and nothing else is wrong."""
    return flown("fault=depth_frozen@40+2000", "fault=deaf_to_u@0+2000")


def test_a_sensor_that_could_not_be_believed_is_told_with_what_it_was_and_when(
    frozen: list[Record],
) -> None:
    chapters = story([frozen])
    sensor, was, begin, noticed, end, times, lasted = chapter(chapters, "Sensors").rows[0]
    assert (sensor, was, times) == ("depth", "frozen", "1")
    assert 38.0 <= seconds(begin) <= 42.0, "from when its value stands"
    assert seconds(begin) + 7.0 < seconds(noticed) <= 52.0, "which five reports tell"
    assert seconds(end) == pytest.approx(frozen[-1].t, abs=2.0)
    assert float(lasted.split()[0]) == pytest.approx(seconds(end) - seconds(begin), abs=1.0)
    assert f"Its depth was not to be believed (frozen) for {lasted} between {begin} and {end}" in (
        as_text("dive", chapters)
    )


def test_a_silence_is_as_long_in_every_sentence_and_table() -> None:
    (items,) = recordings([SHORT])
    silent = [one for one in items if not (is_report(one) and 40.0 < one.t < 52.0)]
    chapters = story([silent])
    (said,) = [line for line in chapters[0].says if "first report of the vehicle in" in line]
    lasted = re.findall(r"in (\d+ s)\.", said)[0]
    stale = [row for row in chapter(chapters, "Sensors").rows if row[1] == "stale"]
    assert stale
    for row in stale:
        assert row[-1] == lasted
        assert seconds(row[2]) <= 40.0 < seconds(row[3]) < seconds(row[4])


def is_report(item: Record | Gap) -> bool:
    return isinstance(item, Record) and item.kind == "rx" and b'"link":"vehicle"' in item.payload


def test_an_attitude_beyond_what_is_believed_is_told_as_what_it_may_be() -> None:
    spells = [Spell("attitude", 1.0, 9.0, "absurd"), Spell("depth", 1.0, 9.0, "absurd")]
    assert [row[:2] for row in summed(spells)] == [
        ("attitude", "absurd, or on its side or back"),
        ("depth", "absurd"),
    ]


def test_a_depth_that_the_estimate_goes_on_to_guess_is_no_report(frozen: list[Record]) -> None:
    """While none could be believed it went on as it had last sunk: 130 s of that were 32 m once."""
    guessed = [
        replace(r, payload=json.dumps(json.loads(r.payload) | {"depth": 9.5}).encode())
        if r.kind == "estimate" and 60.0 < r.t < 90.0
        else r
        for r in frozen
    ]
    before, after = (story([records]) for records in (frozen, guessed))
    assert after[0].says == before[0].says
    assert chapter(after, "Limits") == chapter(before, "Limits")


def test_how_near_the_bottom_came_is_told(frozen: list[Record]) -> None:
    text = as_text("dive", story([frozen]))
    (told,) = re.findall(r"By its altimeter the bottom was no nearer than ([\d.]+) m, at", text)
    assert float(told) == pytest.approx(25.0, abs=1.0), "30 m of water, 5 m deep"


def seconds(clock: str) -> float:
    minutes, _, rest = clock.partition(":")
    return 60.0 * int(minutes) + float(rest)


def test_a_word_that_the_vehicle_does_not_answer_is_told_with_how_often(
    frozen: list[Record],
) -> None:
    rows = chapter(story([frozen]), "Commands to the vehicle").rows
    thrice = [row for row in rows if row[1] == "@ZAU12$" and row[2].endswith("(try 3 of 3)")]
    assert len(thrice) > 1
    often = f"{len(thrice)} times from {thrice[0][0]} to {thrice[-1][0]}"
    text = as_text("dive", story([frozen]))
    assert f"@ZAU12$ took all of its 3 tries {often}: no answer to any of them." in text


def test_an_ascent_that_goes_on_is_told_once_with_all_that_it_tried(frozen: list[Record]) -> None:
    says = story([frozen])[0].says
    (again,) = [line for line in says if "said again" in line]
    assert re.search(
        r"in turn: everything stopped, emergency surfacing, surge 0 heave -1\. All the while its "
        r"reports said (\d\.\d) to \1 m: it did not rise, or its depth is stuck\.$", again,
    )  # fmt: skip
    assert again.count("after 10 s") == 0


def test_an_ascent_whose_depth_falls_is_not_told_as_stuck() -> None:
    for end, stuck in ((4.8, True), (4.4, False)):
        again, says = Again(), list[str]()
        for n in range(5):
            again.report(5.0 if n < 4 else end)
            again.add(
                float(n), "surge 0 heave -1", f"W: after 10 s the depth is {n} m, no less", says
            )
            again.report(5.0 if n < 3 else end)
        assert ("its reports said 4.8 to 5.0 m" in says[0]) is stuck


def test_what_an_ascent_says_over_and_over_is_one_row_a_frame_whatever_depth_it_saw() -> None:
    commands = Commands()
    for n in range(4):
        why = f"W: after 10 s the depth is {3.0 + n / 10} m, no less"
        commands.add(20.0 * n, b"@ZAX0$", why)
        commands.add(20.0 * n + 0.1, b"@ZAU12$", why)
    commands.add(200.0, b"@ZAX0$", "W: after 10 s the depth is 3.0 m, no less")
    says = "W: after 10 s the depth is 3.0 m, no less"
    assert commands.rows() == [
        ("0:00.0", "@ZAX0$", f"{says} (4 times, until 1:00.0)"),
        ("0:00.1", "@ZAU12$", f"{says} (4 times, until 1:00.1)"),
        ("3:20.0", "@ZAX0$", says),
    ]


def test_power_that_an_operator_has_switched_is_told_by_device_once() -> None:
    power = Power()
    said = [
        says
        for t, data in enumerate((b"@RSCCOCOCC$", b"@RSCCOCOCC$", b"@RI$", b"@RSOOOOOOO$"))
        for says in power.sent(float(t), data)
    ]
    assert said == [
        "0:00.0: an operator had power switched: BDGPS, radio on; "
        "CTD, altimeter, UACM, magnetometer, light off.",
        "0:03.0: an operator had power switched: "
        "CTD, altimeter, BDGPS, UACM, radio, magnetometer, light on.",
    ]


def test_a_first_report_that_comes_late_is_told() -> None:
    for t, said in ((4.0, False), (11.0, True)):
        first = list(Unsaid().receive(of_report(t, 1.0), None))
        assert bool(first) is said
    assert first == ["0:11.0: the first report of the vehicle; until then it had said nothing."]


def test_how_deep_it_was_when_the_recording_ends_is_told_where_it_can_be_believed(
    frozen: list[Record],
) -> None:
    assert re.search(r"ends \S+, in idle/ready, 0\.\d m deep by its last report\.$",
                     story([flown()])[0].says[-1])  # fmt: skip
    assert story([frozen])[0].says[-1].endswith(", in emergency/surfaced.")


def test_what_a_vehicle_has_no_sense_for_is_not_told() -> None:
    prepared, recorder = prepare(Path("robot-drive")), ListRecorder()
    fly(prepared.mission, prepared.vehicle, "", 3, parse_settings(()), recorder)
    text = as_text("dive", story([recorder.records]))
    assert "m deep" not in text
    assert "from home" not in text
    limits = chapter(story([recorder.records]), "Limits").rows
    assert [row[0] for row in limits] == ["time", "voltage"], "the others cannot act"


def test_what_is_held_is_told_once_with_how_often_it_was_said() -> None:
    commands = Commands()
    for t in range(4):
        commands.add(float(t), b"\1\2", "entry of dive" + (" (held)" if t else ""))
    commands.add(4.0, b"\3", "entry of up")
    assert commands.rows() == [
        ("0:00.0", "01 02", "entry of dive (4 times, until 0:03.0)"),
        ("0:04.0", "03", "entry of up"),
    ]


def test_each_frame_of_a_boards_round_is_told_once_in_however_many_forms_it_steered() -> None:
    commands = Commands()
    for number in range(30):
        held = " (held)" if number else ""
        steered = bytes([0, 1, 7, 255, number // 10])
        commands.add(number / 10, steered, f"entry of out{held}")
        commands.add(number / 10, b"\xfe\xef\1\1", f"entry of out{held}")
    assert commands.rows() == [
        ("0:00.0", "00 01 07 ff 00", "entry of out (30 times, in 3 forms, until 0:02.9)"),
        ("0:00.0", "fe ef 01 01", "entry of out (30 times, until 0:02.9)"),
    ]


def test_a_frame_that_is_said_again_later_is_told_again() -> None:
    commands = Commands()
    for t, frame in enumerate((b"@ZAS3$", b"@ZAS9$", b"@ZAS3$")):
        commands.add(60.0 * t, frame, "out steers")
    assert [row[:2] for row in commands.rows()] == [
        ("0:00.0", "@ZAS3$"),
        ("1:00.0", "@ZAS9$"),
        ("2:00.0", "@ZAS3$"),
    ]


def test_a_limit_that_comes_and_goes_is_one_alarm_with_how_often() -> None:
    alarms = Rows(60.0)
    for t in (0.0, 2.0, 40.0, 200.0):
        alarms.add(t, "limit", "descent is breached")
        alarms.add(t, "vehicle", "no frame")
    assert alarms.told() == [
        ("0:00.0", "limit", "descent is breached (3 times, until 0:40.0)"),
        ("0:00.0", "vehicle", "no frame (3 times, until 0:40.0)"),
        ("3:20.0", "limit", "descent is breached"),
        ("3:20.0", "vehicle", "no frame"),
    ]


def test_what_operators_said_is_told_by_whom_and_how_it_was_answered_by_modem_too() -> None:
    words = Words()
    words.add(1.0, "topside boat", b"@ACK_AAN$")
    words.add(3.0, "topside boat", b"@ACK_AAA$")
    by_modem = b"#\2\x12\0\2@ACK_AAA$@ACK_ACN$ZX"
    words.add(9.0, "modem", by_modem)
    words.add(12.0, "modem", by_modem)
    assert words.rows() == [
        ("topside boat", "@AA", "refused", "1", "", "0:01.0", "0:01.0"),
        ("topside boat", "@AA", "accepted", "1", "", "0:03.0", "0:03.0"),
        ("modem", "@AA", "accepted", "2", "", "0:09.0", "0:12.0"),
        ("modem", "@AC", "refused", "2", "", "0:09.0", "0:12.0"),
    ]


def test_when_an_operator_said_a_word_is_told_beside_when_it_was_answered() -> None:
    """The vehicle was deaf to an X for five seconds; what is said again waits from the first on."""
    words = Words()
    for t, data in ((41.4, b"@ZAX0$"), (43.0, b"@ZAX0$"), (43.5, b"@SPR600$")):
        words.said(t, "topside boat", data)
    words.add(46.2, "topside boat", b"@ACK_ZXY$")
    words.add(46.3, "topside boat", b"@ACK_SPY$")
    assert [row[1:] for row in words.rows()] == [
        ("@ZX", "accepted", "1", "0:41.4", "0:46.2", "0:46.2"),
        ("@SP", "accepted", "1", "0:43.5", "0:46.3", "0:46.3"),
    ]
    rows = chapter(story(recordings([SHORT])), "Words of operators").rows
    assert all(said and seconds(said) <= seconds(answered) for *_, said, answered, _ in rows)


def test_a_refusal_by_modem_is_told_as_one() -> None:
    (items,) = recordings([SHORT])
    answer = tx_record(Tx(2.0, "modem", b"#\2\t\0\2@ACK_AAN$ZX", "answers by modem"))
    chapters = story([[items[0], answer]])
    assert chapter(chapters, "Refusals").rows == (
        ("0:02.0", "@ACK_AAN$", "answers by modem", "modem"),
    )
    said = [event for event in events_of(answer) if "refused" in event.says]
    assert [event.says for event in said] == ["refused: @ACK_AAN$ - answers by modem"]


def test_what_is_held_has_no_line_of_its_own_in_the_log() -> None:
    told_once = [
        events_of(tx_record(Tx(2.0, "vehicle", b"\1\2", why)))
        for why in ("entry of out", "entry of out (held)")
    ]
    assert [len(events) for events in told_once] == [1, 0]


def test_a_mission_that_is_cleared_is_told_and_its_legs_that_were_never_flown_as_well() -> None:
    (items,) = recordings([SHORT])
    told_before = as_text("dive", story([items]))
    assert "never flown" in told_before
    last = max(item.t for item in items if isinstance(item, Record))
    nothing = Record(last + 1.0, "mission", b'{"digest":"","lines":[]}')
    text = as_text("dive", story([[*items, nothing]]))
    assert f"{clock(last + 1.0)}: no mission is stored." in text
    never = re.search(r"Legs of the mission that were never flown: .*", told_before)
    assert never
    assert never[0] in text


def test_the_depth_of_an_ascent_after_a_restart_counts() -> None:
    (items,) = recordings([AGAIN])
    assert "By its own reports it was" in as_text("dive", story([items]))


def of_report(t: float, depth: float | None) -> Message:
    return Message(TELEMETRY, t, {"depth_m": depth, "latitude_deg": None})


def of_fix(t: float, latitude: float, longitude: float) -> Message:
    return Message(FIX, t, {"latitude_deg": latitude, "longitude_deg": longitude})


def test_a_silence_of_the_vehicle_and_the_first_fix_after_a_dive_are_told() -> None:
    unsaid, home = Unsaid(), Position(30.0, 120.0)
    where = {"north_m": 30.0, "east_m": 40.0, "radius_95_m": 61.2, "state": "idle/ready"}
    at = Message(STATE, 99.0, where)
    said = [
        sentence
        for message in (
            of_report(0.0, 0.0), of_fix(1.0, 30.0, 120.0), of_report(5.0, 0.1),
            of_report(95.5, 0.2), at, of_fix(100.0, 30.0, 120.0), of_fix(101.0, 30.0, 120.0),
        )
        for sentence in unsaid.receive(message, home)
    ]  # fmt: skip
    assert said == [
        "1:35.5: the first report of the vehicle in 90 s.",
        "1:40.0: the first fix in 99 s lay 50 m from where it took itself to be, 95 % sure within 61 m.",
    ]
    assert list(unsaid.at_last(100.0)) == []


def waits(*reports: tuple[float, float], fixes: tuple[float, ...] = (), end: float) -> list[str]:
    """What is said of waiting for a fix, by depths at times and the times of fixes."""
    unfixed, said = Unfixed(), list[str]()
    for t, depth in sorted([*reports, *((t, math.nan) for t in fixes)]):
        said += unfixed.fix(t) if math.isnan(depth) else unfixed.report(t, depth, True)
    return [*said, *unfixed.at_last(end)]


def test_a_long_wait_for_a_fix_at_the_surface_is_told() -> None:
    up = [(float(t), 0.2) for t in range(10, 61, 2)]
    told = "{}: until then it had been at the surface without a fix for {}."
    assert waits(*up, fixes=(45.0,), end=60.0) == [told.format("0:45.0", "35 s")]
    assert waits(*up, (62.0, 3.0), fixes=(11.0, 20.0), end=90.0) == [told.format("1:02.0", "42 s")]
    assert waits(*up, end=60.0) == [told.format("1:00.0", "50 s")]


def test_no_wait_is_told_under_water_in_silence_or_while_fixes_come() -> None:
    up = [(float(t), 0.2) for t in range(10, 61, 2)]
    assert waits(*((t, 3.0) for t, _ in up), end=60.0) == []
    assert waits((10.0, 0.2), (58.0, 0.2), end=60.0) == [], "where it was between is not known"
    assert waits(*up, fixes=(11.0, 35.0), end=60.0) == []
    unfixed = Unfixed()
    assert not [s for t, d in up for s in unfixed.report(t, d, False)], "nor can the depth be"
    assert not list(unfixed.at_last(60.0))


def test_a_vehicle_without_a_receiver_waits_for_no_fix() -> None:
    for receiver in (True, False):
        unsaid = Unsaid(receiver)
        for t in range(0, 80, 2):
            list(unsaid.receive(of_report(float(t), 0.1), None))
        assert bool(list(unsaid.at_last(79.0))) is receiver


def test_a_vehicle_that_knows_its_place_by_itself_waits_for_no_fix() -> None:
    unsaid = Unsaid()
    for t in range(0, 80, 2):
        placed = {"depth_m": 0.1, "latitude_deg": 30.0 if t < 30 else None}
        list(unsaid.receive(Message(TELEMETRY, float(t), placed), None))
    assert list(unsaid.at_last(79.0)) == [
        "1:19.0: until then it had been at the surface without a fix for 51 s."
    ]


def test_sensors_that_were_added_are_not_told_as_believed() -> None:
    unsaid = Unsaid()
    for t in (0.0, 1.0):
        assert not list(unsaid.receive(Message(AID, t, {}), None))
    assert any(line.startswith("Sensors that were added said 2 values;") for line in (
        unsaid.at_last(1.0)
    ))  # fmt: skip
    assert not any("added" in line for line in Unsaid().at_last(1.0))


def test_a_refusal_that_comes_again_is_one_row_with_how_often() -> None:
    refusals = Refusals(60.0)
    for t in (1.0, 2.0, 3.0, 90.0):
        refusals.add(t, "@ACK_AWN$", "idle only", "boat")
    refusals.add(91.0, "@ACK_AWN$", "idle only", "another boat")
    assert refusals.rows() == [
        ("0:01.0", "@ACK_AWN$", "idle only (3 times, until 0:03.0)", "boat"),
        ("1:30.0", "@ACK_AWN$", "idle only", "boat"),
        ("1:31.0", "@ACK_AWN$", "idle only", "another boat"),
    ]


def test_the_last_fix_is_told_where_the_recording_goes_on_long_without() -> None:
    unsaid = Unsaid()
    for message in (of_report(0.0, 9.0), of_fix(1.0, 30.0, 120.0), of_report(98.0, 9.0)):
        list(unsaid.receive(message, None, believed=False))
    assert list(unsaid.at_last(100.0)) == [
        "The last fix came 0:01.0, 99 s before the recording ends."
    ]


@pytest.mark.parametrize(
    ("state", "depths", "told"),
    [
        ("emergency/surfaced", (10.2, 11.0, 39.8), True),
        ("idle/ready", (0.1, 3.0), True),
        ("emergency/stopped", (8.0, 4.0), False),
        ("emergency/surfacing", (1.0, 9.0), False),
        ("autonomous/dive", (1.0, 9.0), False),
    ],
)
def test_what_sank_at_rest_is_told_whatever_its_depth_is_worth(
    state: str, depths: tuple[float, ...], told: bool
) -> None:
    sunk = Sunk()
    for t, one, depth in ((1.0, "autonomous/leg", 99.0), *((9.0, state, d) for d in depths)):
        sunk.state(t, one)
        sunk.report(depth)
    says = f"{state}: its reports said {depths[0]:.1f} m when that began at 0:09.0"
    assert any(says in line for line in sunk.at_last()) is told


def test_a_depth_that_only_the_engine_contradicted_is_told_for_as_long_as_it_did() -> None:
    chapters = story([flown("fault=depth_stuck@12+2000")])
    rows = [row for row in chapter(chapters, "Sensors").rows if row[0] == "depth"]
    (alarm,) = [
        row for row in chapter(chapters, "Alarms").rows if row[2].startswith("depth contradicted")
    ]
    assert rows[0][1] == "contradicted on board"
    assert rows[0][2] == alarm[0]


def test_a_silence_while_a_stick_drives_is_told_as_such() -> None:
    unsaid = Unsaid()
    reports = (of_report(t, 0.1) for t in (0.0, 12.0))
    said = [s for message in reports for s in unsaid.receive(message, None, True, True)]
    assert said == ["0:12.0: the first report of the vehicle, which was driven by hand, in 12 s."]


def test_a_limit_that_an_operator_makes_another_is_told() -> None:
    (items,) = recordings([SHORT])
    at, standing = next((i, r) for i, r in enumerate(items) if getattr(r, "kind", "") == "standing")
    assert isinstance(standing, Record)
    tighter = json.loads(standing.payload) | {"radius": 46.0}
    changed = replace(standing, payload=json.dumps(tighter).encode())
    says = story([[*items[: at + 1], changed, changed]])[0].says
    before = json.loads(standing.payload)["radius"]
    told = f"{clock(standing.t)}: limits in force: radius 46 m, was {before:g}."
    assert [line for line in says if "radius 46 m" in line] == [told]


def test_a_port_without_an_operator_is_told_with_how_long() -> None:
    absence = Absence()
    came_and_went = [(0.0, "connected"), (10.0, "disconnected"), (12.0, "connected"),
                     (30.0, "disconnected"), (31.0, "disconnected"), (50.0, "connected"),
                     (90.0, "disconnected"), (95.0, "disconnected")]  # fmt: skip
    for t, kind in came_and_went:
        absence.receive(input_record(t, kind, "topside", "boat"))
    assert list(absence.at_last(100.0)) == [
        "Nobody was connected to topside for 30 s, 2 times, between 0:30.0 and 1:40.0."
    ]
    assert list(Absence().at_last(100.0)) == []


def test_outputs_that_are_made_safe_are_told_as_such(frozen: list[Record]) -> None:
    (last,) = [r for r in frozen if r.kind == "step"][-1:]
    step = json.loads(last.payload)
    step |= {"entered": [], "actions": ["output video 1: outputs in emergency/surfacing"]}
    made_safe = replace(last, payload=json.dumps(step).encode())
    says = story([[*frozen, made_safe]])[0].says
    assert f"{clock(last.t)}: outputs in emergency/surfacing: video 1." in says


def test_a_vehicle_that_says_nothing_more_is_told_with_its_last_report() -> None:
    unsaid = Unsaid()
    assert list(unsaid.at_last(9.0)) == ["The vehicle never reported."]
    list(unsaid.receive(of_report(10.0, 1.0), None))
    assert list(unsaid.at_last(12.0)) == []
    (said,) = unsaid.at_last(70.0)
    assert said == "The vehicle's last report came 0:10.0, 60 s before the recording ends."


def test_a_first_fix_that_comes_late_is_told_though_there_was_none_before() -> None:
    unsaid = Unsaid()
    assert list(unsaid.receive(of_fix(80.0, 30.0, 120.0), None)) == [
        "1:20.0: the first fix in 80 s."
    ]


def test_fixes_under_a_depth_that_is_not_believed_are_not_told_as_made_up() -> None:
    unsaid = Unsaid()
    for message in (of_report(0.0, 9.0), of_fix(1.0, 30.0, 120.0)):
        assert list(unsaid.receive(message, None, believed=False)) == []
    assert list(unsaid.at_last(2.0)) == []


def test_fixes_from_under_water_are_told_as_such() -> None:
    unsaid, home = Unsaid(), Position(30.0, 120.0)
    for message in (of_report(0.0, 9.0), of_fix(1.0, 30.0, 120.0), of_fix(70.0, 30.0, 120.0)):
        assert list(unsaid.receive(message, home)) == []
    _, said = unsaid.at_last(70.0)
    assert said.startswith("2 fixes came from more than 2 m of depth, from 0:01.0 to 1:10.0")


def begun(seconds: float, path: Path) -> list[Record | Gap]:
    """That recording, as if it had begun so long after 2026 did."""
    (items,) = recordings([path])
    start = items[0]
    assert isinstance(start, Record)
    said = json.loads(start.payload) | {"wall": 1767225600.0 + seconds}
    return [Record(start.t, start.kind, json.dumps(said).encode()), *items[1:]]


def test_two_runs_of_the_program_are_told_in_their_order_with_what_was_under_way() -> None:
    chapters = story([begun(0.0, HEAVY), begun(200.0, AGAIN)])
    titles = [one.title for one in chapters]
    assert titles.count("What happened") == 2
    between = chapters[titles.index("Between two recordings")]
    assert re.search(r"The program began again 93\.7 s later: ", between.says[0])
    assert "was under way" in between.says[0] or "under way was" in between.says[0]
    first = [says for one in chapters[:1] for says in one.says]
    assert first[0].startswith("The program (version")


def test_recordings_of_the_same_time_are_two_and_no_program_that_began_again() -> None:
    for one, other in ((HEAVY, AGAIN), (SHORT, HEAVY)):
        said = restart(begun(0.0, one), begun(10.0, other))
        assert "began again" not in said
        assert re.fullmatch(
            r"--- another recording, begun \d+\.\d s before the one above ended ---", said
        )


def test_what_is_missing_is_told_by_log_and_story(tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    data = bytearray(SHORT.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data[: len(data) * 3 // 4])
    assert "Not everything is on record" in told(path)
    lines = logged(path).stdout
    assert "are missing between" in lines
    assert "is cut behind" in lines


def test_a_closed_file_that_lost_its_beginning_is_told_by_what_is_attached(tmp_path: Path) -> None:
    box, path = BlackBox(tmp_path / "begin.mcap"), tmp_path / "begin.mcap"
    for record in flown():
        box.record(record)
    box.close()
    assert close_part(path)
    data = path.read_bytes()
    whole, first = told(path), data.index(b"zstd")  # of the first chunk, whose size stands before
    path.write_bytes(data[: first + 99] + bytes([data[first + 99] ^ 1]) + data[first + 100 :])
    missing = story(recordings([path]))
    text = as_text("dive", missing)
    assert missing[0].says[0] == told(path).splitlines()[5] == whole.splitlines()[5]
    assert "are missing between its beginning and 20." in missing[0].says[1]
    for made_up in ("first report", "first fix", "never reported"):
        assert made_up not in text, "what was not recorded may have been said"
    assert "m deep at most" in text
    assert logged(path).stdout.splitlines()[1].startswith("2025-")
    attached = data.index(b'"reports"')
    both = bytearray(path.read_bytes())
    both[attached] ^= 1
    path.write_bytes(both)
    assert "nothing says what vehicle it is" in told(path)
    lines = logged(path).stdout.splitlines()
    assert any("vehicle: sent @ZA" in line for line in lines), "what needs no start is told"
    assert all(line.startswith("time not known") for line in lines)


def test_without_a_start_record_no_date_is_made_up(tmp_path: Path) -> None:
    empty = tmp_path / "empty.mcap"
    empty.write_bytes(b"")
    ran = logged(empty)
    assert ran.exit_code == 0
    assert ran.stdout.startswith("time not known               0.000  warning black box: ")


@pytest.mark.proof
def test_a_log_can_be_asked_by_topic_time_and_text() -> None:
    everything = logged(SHORT).stdout.splitlines()
    assert len(everything) > 20
    times = [float(line.split()[2]) for line in everything]
    assert times == sorted(times)
    some = logged(SHORT, "--from", "10", "--to", "60").stdout.splitlines()
    assert some == [one for one, t in zip(everything, times, strict=True) if 10 <= t <= 60]
    sent = logged(SHORT, "--text", "SENT @za").stdout.splitlines()
    assert sent == [line for line in everything if "sent @ZA" in line]
    decoded = logged(SHORT, "--topic", "telemetry", "--json").stdout.splitlines()
    depths = [json.loads(line)["value"]["depth_m"] for line in decoded]
    assert max(depths) > 1.0
    assert logged(SHORT, "--topic", "nothing").exit_code == 2


def test_a_frame_that_somebody_sent_writes_nothing_of_its_own_into_a_terminal(
    tmp_path: Path,
) -> None:
    (items,) = recordings([SHORT])
    box = BlackBox(tmp_path / "b.mcap")
    assert isinstance(items[0], Record)
    box.record(items[0])
    box.record(tx_record(Tx(1.0, "vehicle", b"@ZAX0$", "because \x1b[2J of <b>it</b>")))
    box.close()
    assert "\x1b" not in logged(box.path).stdout
    chapters = story(recordings([box.path]))
    for form in (as_text, as_markdown, as_html):
        text = form("dive", chapters)
        assert "\x1b" not in text
    assert "<b>" not in as_html("dive", chapters)
    assert r"\<b\>" in as_markdown("dive", chapters)


def test_follow_shows_what_comes_from_now_on(tmp_path: Path) -> None:
    (items,) = recordings([SHORT])
    records = [item for item in items if isinstance(item, Record)]
    box = BlackBox(tmp_path / "b.mcap", shell=True)

    def write(some: list[Record]) -> None:
        for record in some:
            box.record(record)
        box.store(box.take())

    write(records[:40])
    rest = iter([records[40:80], records[80:120]])

    class EnoughError(Exception):
        pass

    def sleep(_: float) -> None:
        some = next(rest, None)
        if some is None:
            raise EnoughError
        write(some)

    seen: list[float] = []
    lines = follow(box.path, Wanted(frozenset({"rx"})), sleep)
    with pytest.raises(EnoughError):
        seen.extend(line.t for line in lines)
    wanted = [record.t for record in records[40:120] if record.kind == "rx"]
    assert seen == pytest.approx(wanted)


class Loads(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.loads: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.loads += [value or "" for name, value in attrs if name in ("src", "href")]


def test_the_page_asks_no_other_host_and_has_every_row(tmp_path: Path) -> None:
    page = tmp_path / "story.html"
    ran = CliRunner().invoke(story_command, [str(SHORT), "--form", "html", "-o", str(page)])
    assert ran.exit_code == 0, ran.output
    seen = Loads()
    seen.feed(page.read_text(encoding="utf-8"))
    assert seen.loads == []
    tables = [table for one in story(recordings([SHORT])) for table in one.tables]
    assert seen.tags.count("tr") == sum(len(table.rows) + 1 for table in tables)


def test_what_is_no_black_box_is_refused_with_its_name(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("no black box")
    for command in (log, story_command):
        ran = CliRunner().invoke(command, [str(path)])
        assert ran.exit_code == 2
        assert "notes.txt" in ran.output


def test_where_it_is_at_the_end_how_it_drifts_and_what_is_to_be_done_is_told() -> None:
    """Once it was 84 m from home, but at the end 20 m, adrift, with nobody's thrust."""
    home, lastly = Position(30.0, 120.0), Lastly(frozenset({"position"}))
    lastly.step(moved(5.0, "emergency/surfaced", "everything stopped: the surface is reached"))
    for t in range(10, 40):
        north = 0.5 * (t - 39)
        lastly.receive(of_fix(float(t), *place(home, 20.0 + north, 0.0)))
    lastly.receive(of_state(39.0, home, 20.0, 0.0))
    lastly.receive(
        Message(TELEMETRY, 39.0, {"actuators": {**dict.fromkeys("abcde", 0.0), "servo": 1.0}})
    )
    assert list(lastly.says(40.0, home, True)) == [
        "At the end it was at 30.00018 N 120.00000 E (95 % sure within 2 m), 20 m north (000 deg) of home.",
        "It drifts 0.50 m/s to the north (000 deg), give or take 0.00 m/s, by its fixes of the last 29 s.",
        "By its last report no thruster turns.",
        "The emergency is latched: no mission starts before somebody clears it.",
        "Nothing holds it in its place or brings it home: it has to be fetched.",
    ]
    assert "clears it, twice" in " ".join(lastly.says(40.0, home, False))


def test_a_report_and_an_estimate_from_before_the_end_are_told_as_such() -> None:
    """It was stopped with its last report, and a fix came that no estimate has."""
    home, lastly = Position(30.0, 120.0), Lastly(frozenset({"position"}))
    lastly.receive(Message(TELEMETRY, 20.0, {"actuators": dict.fromkeys("abcde", 1.0)}))
    lastly.receive(of_state(20.0, home, 20.0, 0.0))
    assert "still turn" in " ".join(lastly.says(20.0, home, True)), "nobody stopped it"
    lastly.step(moved(20.0, "idle/ready", "at the surface"))
    lastly.receive(of_fix(21.0, *place(home, 120.0, 0.0)))
    _, fix, turned, _ = lastly.says(21.3, home, True)
    assert fix == "A fix came after that, at 0:21.0: 30.00108 N 120.00000 E, 100 m from there."
    assert turned.endswith(
        "e 100 %. It was stopped after that, and has told nothing of them since."
    )
    lastly.receive(Message(TELEMETRY, 22.0, {"actuators": dict.fromkeys("abcde", 1.0)}))
    assert "thrusters still turn" in " ".join(lastly.says(23.0, home, True))


def test_fixes_that_only_scatter_are_told_as_no_drift() -> None:
    home, lastly = Position(30.0, 120.0), Lastly(frozenset({"position"}))
    for t in range(30):
        lastly.receive(of_fix(float(t), *place(home, 3.0 * (t % 2), 0.0)))
    lastly.step(moved(0.0, "idle/ready"))
    assert any(line.startswith("Whether it drifts cannot be told") for line in (
        lastly.says(30.0, home, True)
    ))  # fmt: skip
    lastly.step(moved(0.0, "autonomous/out"))
    assert not any("drift" in line or "fetched" in line for line in lastly.says(30.0, home, True))


def test_upward_thrust_that_holds_a_heavy_vehicle_up_is_told_with_what_ends_it() -> None:
    lastly = Lastly()
    lastly.step(moved(5.0, "emergency/surfaced"))
    up = {"left_main": 0.0, "rear_vert": 1.0}
    lastly.receive(Message(TELEMETRY, 9.0, {"actuators": up}))
    first, second, *_ = lastly.says(10.0, None, True)
    assert first == "By its last report thrusters still turn: rear_vert 100 %."
    assert "take hold of it before anybody says stop or clear" in second


def test_what_was_held_up_and_is_let_go_is_told_as_stopped_from_then_on() -> None:
    """By a step that leaves no state: AUTO was closed."""
    lastly = Lastly()
    lastly.step(moved(5.0, "emergency/surfaced"))
    lastly.receive(Message(TELEMETRY, 9.0, {"actuators": {"rear_vert": 1.0}}))
    lastly.step(replace(moved(10.0, "", "everything stopped: node AUTO was closed"), entered=()))
    first, second, *_ = lastly.says(11.0, None, True)
    assert first.endswith("It was stopped after that, and has told nothing of them since.")
    assert "take hold of it" not in second


def test_of_several_recordings_distances_are_from_the_home_of_the_first() -> None:
    first, second = begun(0.0, HEAVY), begun(200.0, AGAIN)
    before, after = Teller(first), Teller(second)
    assert before.home is not None
    says = [line for one in story([first, second]) for line in one.says]
    assert sum("of the home of the first recording." in line for line in says) == 1
    assert "first recording" not in as_text("dive", story([second]))
    moved_home = Position(before.home.latitude_deg + 1.0, before.home.longitude_deg)
    far = Teller(second, home=moved_home)
    assert far.home == moved_home
    assert after.home != moved_home
    assert any(
        " m south (180 deg) of the home of" in line for one in far.chapters() for line in one.says
    )


def moved(t: float, path: str, *actions: str) -> Step:
    region = path.partition("/")[0]
    return Step(t, "fix", (), (), (region, path), actions, "surfaced")


def place(home: Position, north: float, east: float) -> tuple[float, float]:
    latitude, longitude = LocalFrame(home).to_geodetic(north, east)
    return math.degrees(latitude), math.degrees(longitude)


def of_state(t: float, home: Position, north: float, east: float) -> Message:
    latitude, longitude = place(home, north, east)
    return Message(STATE, t, {"latitude_deg": latitude, "longitude_deg": longitude,
                              "north_m": north, "east_m": east, "radius_95_m": 2.0})  # fmt: skip


def test_a_vehicle_that_turned_over_is_told_with_when_and_for_how_long() -> None:
    turned = Turned()
    said = [line for t, roll in enumerate((0.0, 170.0, 0.0, 170.0, -178.0, 179.0))
            for line in turned.report(float(t), 2.0, roll)]  # fmt: skip
    assert said == ["0:03.0: it turned over, by its own reports: roll -178 deg, pitch 2 deg."]
    assert list(turned.at_last(9.0)) == [
        "By its last report it still lies turned over (roll 179 deg), for 6 s by then."
    ]
    assert list(turned.report(10.0, 2.0, 3.0)) == [
        "0:10.0: its reports say that it is upright again, after 7 s."
    ]
    assert not list(turned.at_last(11.0))
    unsaid, tilted = (
        Unsaid(),
        {"depth_m": 1.0, "latitude_deg": None, "pitch_deg": 1.0, "roll_deg": 175.0},
    )
    told = [
        line for t in (1.0, 3.0) for line in unsaid.receive(Message(TELEMETRY, t, tilted), None)
    ]
    assert told == ["0:01.0: it turned over, by its own reports: roll 175 deg, pitch 1 deg."]


def operated(*said: tuple[str, str, str]) -> Chapter:
    """What happened, of a start and records (link, to or from, bytes): rx of the vehicle, tx to others."""
    (items,) = recordings([SHORT])
    found = [items[0]]
    for t, (link, why, data) in enumerate(said, 1):
        address = "boat" if link == "topside" else ""
        if why:
            found.append(tx_record(Tx(float(t), link, data.encode(), why, address)))
        else:
            found.append(rx_record(Rx(float(t), link, data.encode(), address), float(t)))
    return story([found])[0]


def test_a_word_that_the_vehicle_refused_is_told_apart_from_one_it_never_answered() -> None:
    """The operator gets N for both."""
    answer = ("topside", "answer of the STM32", "@ACK_ZWN$")
    silent, refused = operated(answer), operated(("vehicle", "", "@ACK_ZWN$"), answer)
    assert "0:01.0: topside boat got N for @ZW: the vehicle gave no answer." in silent.says
    assert "0:02.0: topside boat got N for @ZW: the vehicle answered N." in refused.says


def test_what_the_vehicle_refused_is_in_what_happened() -> None:
    says = story([flown("fault=refuses@30+200")])[0].says
    assert any(line.startswith("The vehicle refused @ZAS5$ ") for line in says)


@pytest.mark.parametrize(
    ("answers", "told"),
    [
        ((False,), "no answer to any of them"),
        ((True,), "only the last was answered"),
        ((True, False), "1 times not even the last was answered"),
    ],
)
def test_whether_the_last_try_was_answered_is_told(answers: tuple[bool, ...], told: str) -> None:
    commands = Commands()
    for t, answered in enumerate(answers):
        commands.add(float(t), b"@ZAWF$", "W (try 3 of 3)")
        if answered:
            commands.heard(b"@ACK_ZAY$")
        commands.add(t + 0.5, b"@ZAX0$", "the surface is reached")
    (said,) = commands.in_vain()
    assert said.endswith(f": {told}.")


def test_a_gap_in_steady_fixes_at_the_surface_is_told() -> None:
    up = [(float(t), 0.2) for t in range(10, 61, 2)]
    steady = tuple(float(t) for t in (*range(11, 21), *range(41, 60)))
    assert waits(*up, fixes=steady, end=60.0) == [
        "0:20.0 to 0:41.0: no fix for 21 s, though it was at the surface."
    ]
    dived = [*up[:8], (26.0, 1.5), *up[9:]]
    assert waits(*dived, fixes=steady, end=60.0) == [], "it was under water between"


def test_an_absurd_depth_makes_no_range_and_what_proved_the_surface_is_told() -> None:
    says = story([flown("fault=depth_full_scale@40+2000", "fault=deaf_to_u@0+2000")])[0].says
    (again,) = [line for line in says if "said again" in line]
    assert "its reports said" not in again, "6553.5 m is no depth"
    (up,) = [line for line in says if "now emergency/surfaced" in line]
    assert up.endswith("is reached, proved by fixes alone, for no depth can be believed.")
    assert any(re.search(r"not known, but \d+ fixes came between", line) for line in says)
    for event, proof in (("fix", "a fix"), ("timer", "a depth that stayed shallow")):
        (up,) = [
            line for line in story([with_step("surfaced", event=event)])[0].says
            if "now emergency/surfaced" in line
        ]  # fmt: skip
        assert up.endswith(f"the surface is reached, proved by {proof}.")


def test_an_ascent_of_a_leg_that_goes_on_in_an_emergency_is_told_as_that() -> None:
    again, says = Again(), list[str]()
    again.add(9.0, "surge 0 heave -1", "entry of up: after 10 s the depth is 33.0 m, no less", says)
    assert says[0].startswith("0:09.0: the ascent that up began: after 10 s the depth is 33.0 m")


def test_the_least_that_was_left_of_the_depth_agrees_with_the_deepest_report() -> None:
    chapters = story(recordings([HEAVY]))
    deepest = next(
        float(found[1]) for line in chapters[0].says
        if (found := re.search(r"it was ([\d.]+) m deep at most", line))
    )  # fmt: skip
    (row,) = [row for row in chapter(chapters, "Limits").rows if row[0] == "depth"]
    bound, left = (float(cell.split()[0]) for cell in row[1:3])
    assert left == pytest.approx(bound - deepest, abs=0.051)


def test_why_the_program_ended_is_told_where_the_record_has_it() -> None:
    first, second = begun(0.0, HEAVY), begun(200.0, AGAIN)
    ended = [*(one for one in first if getattr(one, "kind", "") != "ending")]
    says = between(ended, second).says
    assert says[1:] == ("Why it ended is not on record.",)
    last = max(one.t for one in ended if isinstance(one, Record))
    told = [*ended, input_record(last, "ending")]
    assert between(told, second).says[1:] == ("It had been told to end.",)
