"""Depth and heading closed on the Pi for the ROV, over its own bytes; and that nothing is held until
somebody has seen its axes and signs (R17, E-R8)."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from test_doctor_boards import simulated_board

from links.simulated.settings import parse_settings
from mission.authoring.prepare import Prepared, Unreadable, prepare
from mission.commands.doctor import doctor
from mission.model import Action, Result
from mission.model.shipped import load_vehicle
from mission.model.vehicle import CLOSED_S, OuterLoop
from mission.onboard.doctor.signs import sign_findings
from mission.onboard.runtime.outer_loop import GROWS_S, LoopCloser
from mission.onboard.runtime.repeater import Repeater
from mission.verification.simulation.flight import fly
from mission.verification.simulation.flightlog import Flight
from protocol.codec import CannotEncode
from protocol.framing import Frame
from protocol.messages import Order, Setpoint, Telemetry
from protocol.tolerances import Tolerances
from protocol.vehicles import codec, link

SHIPPED = Path("missions/vehicles/rov.yaml").read_text(encoding="utf-8")
NEUTRAL = Order.STOP  # which leaves nothing on that the board holds by itself
CONFIRMED = SHIPPED.replace("# confirmed:", "confirmed:")
HOLD = """mission rov-hold vehicle rov
safety time 20min depth 20
assume current 0
start without fix
dive: depth 3 heading 90 until depth >= 2.8 held 3s timeout 60s
out: gear 4 for 20s
turn: depth 5 heading 200 gear 3 for 40s
up: surface timeout 3min
"""


def ready(folder: Path, vehicle: str = CONFIRMED) -> Prepared:
    (folder / "rov.yaml").write_text(vehicle, encoding="utf-8")
    (folder / "hold.mission").write_text(HOLD, encoding="utf-8")
    return prepare(folder / "hold.mission", str(folder / "rov.yaml"))


def loop() -> OuterLoop:
    found = load_vehicle("rov").outer_loop
    assert found is not None
    return found


@pytest.mark.proof
def test_the_rov_holds_depth_and_heading_and_comes_up(tmp_path: Path) -> None:
    made = ready(tmp_path)
    flight = fly(made.mission, made.vehicle, seed=3)
    assert flight.outcome == "completed", flight.reason
    assert [leg.by for leg in flight.legs] == ["until", "for", "for", "end", "end"]
    begun = next(p.t for p in flight.track if p.depth > 0.25)
    east = [p for p in flight.track if begun + 14 < p.t < begun + 28]
    assert all(abs(p.depth - 3.0) < 0.35 for p in east)
    speed = (east[-1].east - east[0].east) / (east[-1].t - east[0].t)
    assert speed == pytest.approx(made.vehicle.speed_by_gear.at(4), rel=0.2)
    assert abs(east[-1].north - east[0].north) < 0.5
    deep = [p for p in flight.track if begun + 50 < p.t < begun + 65]
    assert all(abs(p.depth - 5.0) < 0.35 for p in deep)
    course = math.atan2(deep[-1].east - deep[0].east, deep[-1].north - deep[0].north)
    assert math.degrees(course) % 360 == pytest.approx(200, abs=6)
    assert flight.at_surface


def test_nothing_is_held_until_the_vehicle_file_confirms_axes_and_signs(tmp_path: Path) -> None:
    with pytest.raises(Unreadable) as caught:
        ready(tmp_path, SHIPPED)
    assert {d.code for d in caught.value.diagnostics} == {"signs-unconfirmed"}
    assert "doctor --signs" in str(caught.value)
    board = codec(*load_vehicle("rov").speaks)
    with pytest.raises(CannotEncode):
        board.encode(Setpoint(depth=3.0))


# --- the loop alone ------------------------------------------------------------------------------


def asked(closer: LoopCloser, until: float, depth: float, rate: float = 0.0) -> Setpoint | Order:
    """Reports at 20 Hz from 0 on; what is asked of the board behind the last."""
    wanted = Setpoint(surge=0.3, depth=3.0)
    closer.hold(wanted)
    for i in range(round(20 * until) + 1):
        closer.report(Telemetry(i / 20, depth=depth + rate * i / 20))
    return closer.closed(wanted, until)


def told(closer: LoopCloser, until: float, depth: float) -> Setpoint:
    """The same, of what is no order."""
    efforts = asked(closer, until, depth)
    assert isinstance(efforts, Setpoint)
    assert efforts.depth is None
    return efforts


def test_the_effort_is_down_above_the_depth_up_below_it_and_within_its_bound() -> None:
    most = loop().depth.most
    assert told(LoopCloser(loop()), 1.0, 0.0).heave == most
    assert told(LoopCloser(loop()), 1.0, 9.0).heave == -most
    near = told(LoopCloser(loop()), 1.0, 3.0)
    assert near.heave == pytest.approx(loop().depth.trim)
    assert near.surge == 0.3


def test_a_report_that_is_older_than_half_a_second_is_neutral() -> None:
    closer = LoopCloser(loop())
    told(closer, 1.0, 2.0)
    wanted = Setpoint(surge=0.3, depth=3.0)
    assert closer.closed(wanted, 1.0 + CLOSED_S) != NEUTRAL
    assert closer.closed(wanted, 1.001 + CLOSED_S) == NEUTRAL
    closer.report(Telemetry(2.0, depth=2.0))
    assert closer.closed(wanted, 2.0) != NEUTRAL


def test_the_board_holds_no_depth_by_itself_beside_one_that_the_pi_holds_or_has_given_up() -> None:
    board = codec(*load_vehicle("rov").speaks)
    board.take_outputs({"hold_depth": 1.0})
    line = Repeater(board.encode, board.period, closer=LoopCloser(loop()))
    (down,) = link("rov.down").frames(Tolerances())
    line.command(Action(Setpoint(depth=3.0), "a leg"))
    flags, efforts = set(), set()
    for i in range(1, 120):
        now = i / 20
        if not 2.0 < now < 4.0:  # no report: neutral; behind it the depth runs away: given up
            line.report(Telemetry(now, depth=2.0 - max(0.0, now - 4.0)))
        for tx in line.poll(now)[0]:
            values = down.decode(tx.data)
            flags.add(values["hold_depth"])
            efforts.add(values["f"])
    assert 0.0 in efforts, "neutral was said"
    assert flags == {0}


def test_a_report_without_the_reading_does_not_count() -> None:
    closer = LoopCloser(loop())
    told(closer, 1.0, 2.0)
    for i in range(20):
        closer.report(Telemetry(1.05 + i / 20, heading=1.0))
    assert closer.closed(Setpoint(depth=3.0), 2.0) == NEUTRAL


@pytest.mark.parametrize("fault", ["ez_deg:out_of_range", "yaw_deg:out_of_range"])
def test_a_heading_that_its_report_flags_is_not_steered_by(fault: str) -> None:
    """It is passed over: no effort follows from it, no error grows, and for 0.5 s nothing is lost."""
    closer, wanted = LoopCloser(loop()), Setpoint(depth=3.0, heading=1.0)
    closer.hold(wanted)
    for i in range(20):
        closer.report(Telemetry(i / 20, depth=3.0, heading=1.0))
    before = closer.closed(wanted, 0.95)
    for i in range(20, 31):
        closer.report(Telemetry(i / 20, depth=3.0, heading=4.0, faults=(fault,)))
        assert (closer.closed(wanted, i / 20) == before) is (i <= 29)
    assert closer.fault == ""
    assert closer.closed(wanted, 1.5) == NEUTRAL
    closer.report(Telemetry(1.55, depth=3.0, heading=1.0, faults=("ex_deg:nan",)))
    assert closer.closed(wanted, 1.55) != NEUTRAL


def test_each_of_two_readings_that_are_held_by_has_to_be_as_young() -> None:
    closer, wanted = LoopCloser(loop()), Setpoint(depth=3.0, heading=1.0)
    closer.hold(wanted)
    closer.report(Telemetry(1.0, depth=2.0, heading=1.0))
    assert closer.closed(wanted, 1.1) != NEUTRAL
    for i in range(20):
        closer.report(Telemetry(1.05 + i / 20, heading=1.0))
    assert closer.closed(wanted, 2.0) == NEUTRAL


def test_a_new_set_begins_with_nothing_of_the_effort_of_an_earlier_one() -> None:
    closer, most = LoopCloser(loop()), loop().depth.most
    assert told(closer, 1.0, 0.0).heave == most
    closer.hold(Order.STOP)
    for i in range(21, 200):
        closer.report(Telemetry(i / 20, depth=8.0))
    up = Setpoint(depth=2.0)
    closer.hold(up)
    efforts = closer.closed(up, 10.0)
    assert isinstance(efforts, Setpoint)
    assert efforts.heave == -most


def test_a_new_set_whose_axis_was_not_reported_begins_neutral() -> None:
    closer = LoopCloser(loop())
    told(closer, 1.0, 0.0)
    closer.hold(Order.STOP)
    for i in range(21, 200):
        closer.report(Telemetry(i / 20, heading=1.0))
    closer.hold(Setpoint(depth=2.0))
    assert closer.closed(Setpoint(depth=2.0), 10.0) == NEUTRAL


@pytest.mark.parametrize("absurd", [-3e38, -1e4, 655.35, 3e38])
@pytest.mark.parametrize("at", [0, 100, 199, 200, 210])
def test_one_absurd_depth_is_left_out_before_a_set_and_in_it(absurd: float, at: int) -> None:
    closer, begin = LoopCloser(loop()), 200
    wanted = Setpoint(depth=3.0)
    for i in range(begin + 100):
        if i == begin:
            closer.hold(wanted)
        closer.report(Telemetry(i / 20, depth=absurd if i == at else 3.0))
        efforts = closer.closed(wanted, i / 20)
        if i >= begin:
            assert isinstance(efforts, Setpoint)
            assert efforts.heave == pytest.approx(loop().depth.trim)
    assert closer.fault == ""


@pytest.mark.parametrize("hertz", [10, 20, 50])
@pytest.mark.parametrize("name", ["depth", "heading"])
def test_a_reading_that_is_wrong_for_less_than_a_second_ends_no_holding(
    name: str, hertz: int
) -> None:
    """A board may say 50 times a second what its sensor says twice."""
    closer, wanted = LoopCloser(loop()), Setpoint(depth=3.0, heading=1.0)
    closer.hold(wanted)
    for i in range(8 * hertz):
        right = Telemetry(i / hertz, depth=3.0, heading=1.0)
        wrong = right._replace(**{name: 9.0 if name == "depth" else 4.0})  # type: ignore[arg-type]
        closer.report(wrong if 2.0 <= right.t < 2.9 else right)
        efforts = closer.closed(wanted, right.t)
        if isinstance(efforts, Setpoint):
            assert efforts.turn == pytest.approx(0.0)
            assert efforts.heave == pytest.approx(loop().depth.trim)
        else:
            assert 2.3 < right.t < 2.9
    assert closer.fault == ""


@pytest.mark.parametrize("name", ["depth", "heading"])
def test_a_reading_that_stays_elsewhere_for_a_second_counts(name: str) -> None:
    closer, wanted = LoopCloser(loop()), Setpoint(depth=30.0, heading=1.0)
    closer.hold(wanted)
    for i in range(40):
        report = Telemetry(i / 20, depth=30.0, heading=1.0)
        if report.t > 0.5:
            report = report._replace(**{name: 4.0})  # type: ignore[arg-type]
        closer.report(report)
        assert bool(closer.fault) is (report.t > 1.5), "the error has grown"
    wanted = Setpoint(depth=31.0, heading=5.0)
    closer.hold(wanted)
    efforts = closer.closed(wanted, 39 / 20)
    assert isinstance(efforts, Setpoint)
    held = efforts.heave if name == "depth" else efforts.turn
    assert held == (loop().depth.most if name == "depth" else loop().heading.most)


@pytest.mark.parametrize("wild", [2.2, 3.8])
def test_a_depth_that_is_a_metre_off_for_half_a_second_is_no_growth(wild: float) -> None:
    """Farther off, or nearer: then the way back is none. It is no leap, either."""
    closer, wanted = LoopCloser(loop()), Setpoint(depth=9.0)
    closer.hold(wanted)
    for i in range(200):
        closer.report(Telemetry(i / 20, depth=wild if 60 <= i < 70 else 3.0, heading=1.0))
        assert closer.fault == ""


@pytest.mark.parametrize(("rate", "given_up"), [(-0.09, False), (-0.11, True), (0.1, False)])
def test_an_error_that_grows_by_half_a_metre_in_5_s_ends_the_holding(
    rate: float, given_up: bool
) -> None:
    closer = LoopCloser(loop())
    assert (asked(closer, 2 * GROWS_S, 2.0, rate) == NEUTRAL) is given_up
    assert bool(closer.fault) is given_up
    closer.hold(Setpoint(depth=1.0))
    assert closer.fault == ""


def given_up() -> LoopCloser:
    """3 m asked for; it rose from there for 6 s."""
    closer = LoopCloser(loop())
    asked(closer, 6.0, 3.0, -0.15)
    assert closer.fault
    return closer


@pytest.mark.parametrize("heading", [None, 1.0])
def test_the_set_behind_one_that_was_given_up_begins_with_no_error_of_its(
    heading: float | None,
) -> None:
    closer, wanted = given_up(), Setpoint(depth=3.0, heading=heading)
    closer.hold(wanted)
    for i in range(121, 240):  # it comes back
        closer.report(Telemetry(i / 20, depth=2.1 + (i - 120) / 200, heading=1.0))
        assert closer.fault == ""
        assert closer.closed(wanted, i / 20) != NEUTRAL
    closer.hold(wanted)
    for i in range(240, 400):  # and goes again
        closer.report(Telemetry(i / 20, depth=2.7 - (i - 240) / 100, heading=1.0))
    assert closer.fault


def test_a_set_that_is_said_again_keeps_its_errors() -> None:
    closer, wanted = LoopCloser(loop()), Setpoint(depth=3.0)
    for i in range(120):
        closer.hold(wanted)
        closer.report(Telemetry(i / 20, depth=3.0 - i / 130))
        if closer.fault:
            break
    assert closer.fault


@pytest.mark.parametrize("gone", ["depth", "heading"])
def test_what_grew_while_the_vehicle_was_neutral_for_want_of_a_reading_was_not_held(
    gone: str,
) -> None:
    closer, wanted = LoopCloser(loop()), Setpoint(depth=3.0, heading=1.0)
    closer.hold(wanted)
    for i in range(160):
        away = 60 <= i < 120
        rise = 0.015 * min(max(i - 70, 0), 50)  # 0.75 m, from 0.5 s on
        report = Telemetry(i / 20, depth=3.0 - rise, heading=1.0)
        closer.report(report._replace(**{gone: None}) if away else report)  # type: ignore[arg-type]
        assert closer.fault == ""
    assert closer.closed(wanted, 159 / 20) != NEUTRAL


def test_what_grows_under_thrust_is_told_though_another_reading_has_gaps() -> None:
    """The heading fails for 0.7 s of each 2 s; the depth goes the wrong way whenever it thrusts."""
    closer, wanted = LoopCloser(loop()), Setpoint(depth=3.0, heading=1.0)
    closer.hold(wanted)
    depth = 3.0
    for i in range(200):
        depth += 0.01 * (closer.closed(wanted, i / 20) != NEUTRAL)
        closer.report(Telemetry(i / 20, depth=depth, heading=1.0 if i % 40 < 26 else None))
    assert "depth is not held" in closer.fault


def test_a_heading_is_held_the_short_way_round() -> None:
    closer = LoopCloser(loop())
    wanted = Setpoint(heading=math.radians(10))
    closer.hold(wanted)
    for i in range(40):
        closer.report(Telemetry(i / 20, heading=math.radians(350)))
    efforts = closer.closed(wanted, 1.95)
    assert isinstance(efforts, Setpoint)
    assert 0.0 < efforts.turn <= loop().heading.most
    assert efforts.heave is None


def test_orders_and_sets_that_hold_nothing_go_through_as_they_are() -> None:
    closer = LoopCloser(loop())
    for command in (Order.STOP, Order.SURFACE, Setpoint(surge=0.5, heave=0.2)):
        closer.hold(command)
        assert closer.closed(command, 9.0) == command


def test_a_set_that_is_given_up_is_refused_once_and_the_board_told_neutral() -> None:
    board = codec("rov", "documented", {})
    line = Repeater(board.encode, board.period, closer=LoopCloser(loop()))  # type: ignore[attr-defined]
    line.command(Action(Setpoint(depth=3.0), "a leg"))
    results, sent, now = [], [b""], 0.0
    while now < 12.0:
        now = round(now + 0.05, 6)
        line.report(Telemetry(now, depth=2.0 - 0.2 * now))
        out, outcomes = line.poll(now)
        results += [o for o in outcomes if o.result is Result.REFUSED]
        sent += [tx.data for tx in out]
    assert [o.frame.decode()[:17] for o in results] == ["depth is not held"]
    assert sent[-1] == board.encode(Setpoint())[0]
    line.command(Action(Setpoint(depth=4.0), "another leg"))
    while now < 24.0:
        now = round(now + 0.05, 6)
        line.report(Telemetry(now, depth=2.0 - 0.2 * now))
        results += [o for o in line.poll(now)[1] if o.result is Result.REFUSED]
    assert len(results) == 2, "the next one is, too"


# --- over the bytes of a flight ------------------------------------------------------------------

SILENT_AT, SILENT_S = 24.0, 2.0


def efforts(flight: Flight, begin: float, end: float) -> list[tuple[float, float, float]]:
    """X, Z and F as the board reads them."""
    framer = link("rov.down").framer(Tolerances())
    sent = [tx.data for tx in flight.sent if tx.link == "vehicle" and begin < tx.t < end]
    frames = [frame for data in sent for frame in framer.receive(data, 0.0)]
    assert all(isinstance(frame, Frame) for frame in frames)
    values = [frame.values() for frame in frames if isinstance(frame, Frame)]
    return [(v["x"], v["z"], v["f"]) for v in values]


@pytest.mark.proof
def test_a_rov_whose_report_is_older_than_half_a_second_is_told_neutral_on_its_wire(
    tmp_path: Path,
) -> None:
    made = ready(tmp_path)
    silence = parse_settings((f"fault=stm32_silent@{SILENT_AT}+{SILENT_S}",))
    flight = fly(made.mission, made.vehicle, seed=3, settings=silence)
    known = SILENT_AT + CLOSED_S
    assert (0.0, 0.0, 0.0) not in efforts(flight, SILENT_AT - 2.0, known - 0.06)
    assert set(efforts(flight, known + 0.06, SILENT_AT + SILENT_S)) == {(0.0, 0.0, 0.0)}
    back = efforts(flight, SILENT_AT + SILENT_S + 0.2, SILENT_AT + SILENT_S + 2.0)
    assert (0.0, 0.0, 0.0) not in back
    assert (flight.outcome, flight.at_surface) == ("completed", True)


def test_a_rov_that_turns_the_other_way_is_told_neutral_on_its_wire_and_its_mission_ends(
    tmp_path: Path,
) -> None:
    """The file confirms a sign that is not so: the error grows, and the set is refused."""
    other = CONFIRMED.replace("tolerances:", "wire: {z_sign: -1}\ntolerances:", 1)
    made = ready(tmp_path, other)
    flight = fly(made.mission, made.vehicle, seed=3)
    assert flight.legs[0].by == "else"
    told = efforts(flight, 0.0, math.inf)
    rises = next(i for i, (x, z, f) in enumerate(told) if x == z == 0.0 and f > 0.9)
    assert (0.0, 0.0, 0.0) not in told[1:20], "it turns, and dives"
    assert told[rises - 1] == (0.0, 0.0, 0.0)
    assert flight.at_surface


# --- the guided check ----------------------------------------------------------------------------


def signs_of(folder: Path, wire: str = "") -> list[dict[str, str]]:
    vehicle = folder / "rov.yaml"
    vehicle.write_text(SHIPPED + wire, encoding="utf-8")
    with simulated_board("rov") as device:
        config = folder / "serve.yaml"
        links = {"vehicle": f"serial://{device}", "gps": None, "topside": "tcp://127.0.0.1:0"}
        config.write_text(
            f"vehicle: {vehicle}\nfolder: {folder / 'pi'}\nlinks: {json.dumps(links)}\n"
        )
        words = ["-c", str(config), "--signs", "--in-water", "--json"]
        found = json.loads(CliRunner().invoke(doctor, words).stdout)["findings"]
    return [one for one in found if one["what"] == "axes and signs"]


def test_doctor_moves_the_vehicle_and_tells_that_its_signs_are_as_read(tmp_path: Path) -> None:
    depth, heading, ahead = signs_of(tmp_path)
    assert [found["state"] for found in (depth, heading, ahead)] == ["ok"] * 3
    assert "confirmed" in depth["todo"]
    assert ahead["says"] == "it was pushed ahead with 30% for 3 s"
    assert "x_sign: -1" in ahead["todo"]


def test_doctor_tells_a_sign_that_is_the_other_way_and_what_to_write(tmp_path: Path) -> None:
    _, heading, *_ = signs_of(tmp_path, "wire: {z_sign: -1}\n")
    assert heading["state"] == "fault"
    assert "z_sign: -1" in heading["todo"]


def test_doctor_tells_at_which_speed_and_which_way_thrusters_turn_and_what_to_write(
    tmp_path: Path,
) -> None:
    found = signs_of(tmp_path, "wire: {left_up_rpm: -400, right_front_rpm: 500}\n")
    assert [one["state"] for one in found] == ["ok", "warning", "ok", "warning", "ok", "warning"]
    down, turned, ahead = (one for one in found if one["state"] == "warning")
    assert "left_up reports +100% where it was told -90%" in down["says"]
    assert "right_up" not in down["says"]
    (rpm,) = re.findall(r"wire: {left_up_rpm: (-?\d+)}", down["todo"])
    assert int(rpm) == pytest.approx(444, abs=30), "as far as the field was read: try again"
    for said in (turned, ahead):
        assert "right_front reports" in said["says"]
        assert "left_front" not in said["says"]


class Sea:
    """What is reported ten times a second of a vehicle that obeys at once."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **more: float) -> None:
        self.t = self.depth = self.heading = 0.0
        self.asleep, self.turn_rate = more.get("asleep", 0.0), math.radians(more["turn_rate"])
        self.flags, self.pushed = bool(more.get("flags")), 0
        monkeypatch.setattr("mission.onboard.doctor.signs._say", self.say)
        monkeypatch.setattr("mission.onboard.doctor.signs.time.monotonic", lambda: self.t)
        monkeypatch.setattr("mission.onboard.doctor.signs.open_whole", lambda *_: MemoryLink)

    def say(self, _: object, __: object, effort: Setpoint, seconds: float) -> list[Telemetry]:
        heard = []
        self.pushed += effort != Setpoint()
        for _ in range(round(10 * seconds)):
            self.t += 0.1
            self.depth += 0.03 * (effort.heave or 0.0)
            self.heading += 0.2 * self.turn_rate * effort.turn
            wakes = self.t < self.asleep
            self.heading -= 0.05 if wakes else 0.0
            board = (("ins_aligned", float(not wakes)),) if self.flags else ()
            told = math.remainder(self.heading, math.tau)
            heard.append(Telemetry(self.t, depth=self.depth, heading=told, board=board))
        return heard


class MemoryLink:
    @staticmethod
    def close() -> None:
        pass


@pytest.mark.parametrize("turn_rate", [30.0, 62.0, 75.0, 140.0])
def test_doctor_takes_no_nimble_vehicle_for_one_that_turns_the_other_way(
    turn_rate: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    Sea(monkeypatch, turn_rate=turn_rate)
    found = list(sign_findings("serial:///dev/rov", load_vehicle("rov")))
    assert [one.condition.name.lower() for one in found] == ["ok"] * 3
    (grown,) = re.findall(r"the heading changed by (-?\d+) deg", found[1].says)
    assert 0.9 * 3 * turn_rate <= float(grown) <= 3 * turn_rate


@pytest.mark.parametrize("flags", [0.0, 1.0])
def test_doctor_moves_nothing_until_the_sensors_are_awake(
    flags: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    vehicle = load_vehicle("mainboard")
    sea = Sea(monkeypatch, turn_rate=30.0, asleep=30.0, flags=flags)
    assert [one.condition.name.lower() for one in sign_findings("serial:///dev/x", vehicle)] == [
        "ok"
    ] * 3
    sea = Sea(monkeypatch, turn_rate=30.0, asleep=300.0, flags=flags)
    (found,) = sign_findings("serial:///dev/x", vehicle)
    assert (found.condition.name.lower(), sea.pushed) == ("warning", 0)
    assert found.says.endswith(": nothing was tried")
    assert ("the INS is not aligned" in found.says) == bool(flags)
