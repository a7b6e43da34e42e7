"""The vehicle's situation as the runtime knows it at one instant: for @VS, @AE, alarms and health.

    Telemetry, Fix, commands that left --> Situation --> Status (@VS) | StateReport (@AE)
                                                     --> Condition (alarms)

All of it follows from recorded inputs. Of what only serve knows (links, disk, clock), the names of
the alarms are an input. What does not live here: frames (protocol), the rest of serve's health
(serve.health).
"""

from __future__ import annotations

import math
from collections import deque

from mission.engine.engine import Engine
from mission.model import AUTONOMOUS, MANUAL_DRIVING, SURFACING, Action, Estimate, Step
from mission.model.alarms import Condition, mask_of, standing
from mission.model.regions import EMERGENCY, MANUAL
from mission.model.vehicle import Vehicle
from mission.navigation.distribution import around_95
from mission.navigation.fixes import FIX_DEPTH
from mission.onboard.runtime.command_target import MODEM, Peer, one_line
from mission.onboard.runtime.refusals import DOUBT_S
from protocol.messages import Fix, Order, Setpoint, StateReport, Telemetry
from protocol.state_frame import STICK, setpoint_text

AT_SURFACE_M = 0.5
FRESH_FIX_S = 5.0
TELEMETRY = "telemetry"  # a limit that has an alarm of its own
TREND_EVERY_S, TREND_LEAST, TREND_MOST = 10.0, 30, 60  # samples: of 5 to 10 minutes


class Situation:
    """``gps``: whether there is a receiver."""

    def __init__(self, engine: Engine, vehicle: Vehicle, gps: bool) -> None:
        self._engine, self._vehicle, self._gps = engine, vehicle, gps
        self.telemetry: Telemetry | None = None
        self.fix: Fix | None = None  # of a receiver
        self._own: Fix | None = None  # without a receiver: its own position, last at the surface
        self._said: Setpoint | Order | None = None
        self._deep_at = 0.0  # when it was last not at the surface, or the depth unknown
        self._volts: deque[tuple[float, float]] = deque(maxlen=TREND_MOST)
        self._owes_report = False
        self._has_news = False  # a report, a fix or a step since the last look at the surface
        self.of_serve: tuple[str, ...] = ()  # alarms that serve has reported
        self._ahead: tuple[Estimate | None, float, Estimate | None] = None, 0.0, None

    def note(self, step: Step) -> None:
        """Note a step. A vehicle that was under way owes the boat one @VS at the surface (R11)."""
        self._has_news = True
        if any(path.startswith((AUTONOMOUS, EMERGENCY)) for path in step.entered):
            self._owes_report = True

    def owes_report(self, now: float) -> bool:
        """Whether that @VS is due: true once. Checked only after a new report, fix or step."""
        if not (self._owes_report and self._has_news):
            return False
        self._has_news = False
        under_way = self._engine.state.startswith((AUTONOMOUS, MANUAL, SURFACING))
        is_due = not under_way and self._afloat(now)
        self._owes_report = not is_due
        return is_due

    def take_fix(self, fix: Fix) -> None:
        self.fix, self._has_news = fix, True

    def report(self, report: Telemetry) -> None:
        self.telemetry, self._has_news = report, True
        if report.depth is None or report.depth >= AT_SURFACE_M:
            self._deep_at = report.t
        volts = report.batteries[0] if report.batteries else None
        is_due = not self._volts or report.t >= self._volts[-1][0] + TREND_EVERY_S
        if volts is not None and is_due and not self._vehicle.constant_batteries:
            self._volts.append((report.t, volts))

    def locate(self) -> None:
        """Without a receiver: take the position of the last report, whose depth the engine has
        judged."""
        report, depth = self.telemetry, self._engine.core.vehicle_state.depth
        if self._gps or report is None or report.position is None:
            return
        if depth is not None and depth < AT_SURFACE_M:
            self._own = Fix(report.t, *report.position, accuracy=math.inf)

    def commanded(self, action: Action) -> None:
        if isinstance(action.command, Setpoint | Order):
            self._said = action.command

    @property
    def setpoint(self) -> str:
        """The setpoint in force, as it was last sent to the vehicle."""
        return STICK if self._engine.state == MANUAL_DRIVING else setpoint_text(self._said)

    def _afloat(self, now: float) -> bool:
        """Whether it is at the surface: by the depth, or by fixes that no depth contradicts."""
        known = self._engine.core.vehicle_state
        depth = known.depth if self.telemetry is not None else None
        if depth is None:
            return known.receiver.at_surface(now)
        return depth < AT_SURFACE_M or (depth < FIX_DEPTH and known.fixed(now - FRESH_FIX_S))

    def condition(
        self, refusal: str, refused_at: float, now: float, receivers: str = ""
    ) -> Condition:
        """What the alarms go by. ``receivers``: what is wrong with the GPS receivers."""
        engine = self._engine
        watch, within = engine.core.watch, self._vehicle.stale_after
        breached = {row.name: row.why(watch) for row in engine.breaches if row.name != TELEMETRY}
        return Condition(
            state=engine.state,
            reason=engine.reason,
            breached=breached,
            unobeyed=now - engine.doubted_at <= DOUBT_S,
            unproved=self._unproved(now),
            report_age=self.report_age(now) if self.telemetry or now > within else None,
            reports_within=within,
            afloat_without_fix=self._without_fix(now),
            receivers=receivers,
            refusal=refusal,
            refusal_age=now - refused_at if refusal else None,
            battery_runs_out=self._runs_out(),
        )

    def _unproved(self, now: float) -> float | None:
        core = self._engine.core
        if core.ascent is None or core.vehicle_state.depth is not None:
            return None
        return now - core.ascent.began

    def state_report(
        self, condition: Condition, asker: Peer, commander: Peer | None, now: float
    ) -> StateReport:
        engine = self._engine
        north, east = self._drift(now)
        left = self.margins(now)
        names = (*(alarm.name for alarm in standing(condition)), *self.of_serve)
        state = AUTONOMOUS if engine.state.startswith(AUTONOMOUS) else engine.state
        return StateReport(
            state=state,
            commander=_whose(asker, commander),
            report_age=_finite(self.report_age(now)),
            fix_age=self.fix_age(now),
            uncertainty_m=self.uncertainty(now),
            north_m=north,
            east_m=east,
            to_depth_m=left["depth"],
            to_radius_m=left["radius"],
            to_time=left["time"],
            to_voltage_v=left["voltage"],
            alarms=mask_of(names),
            setpoint=self.setpoint,
            leg=one_line(engine.leg),
        )

    @property
    def shown(self) -> Fix | None:
        """The fix that ``@VS`` reports: where the vehicle is, or where it dived (R9). With a
        receiver only its fixes count: the vehicle's own position is no fix (R11)."""
        return self.fix or self._own

    def report_age(self, now: float) -> float:
        """Age of the last report, s; inf if none ever came."""
        return now - self.telemetry.t if self.telemetry else math.inf

    def fix_age(self, now: float) -> float | None:
        """Age of the fix that is shown, s; without a receiver, of the vehicle's own position."""
        if (shown := self.shown) is not None:
            return now - shown.t
        estimate = self._engine.estimate
        return None if self._gps or estimate is None else estimate.fix_age

    def estimate(self, now: float) -> Estimate | None:
        """The estimate at ``now``. The engine's own is of its last step, and no step comes while
        the board is silent and no timer is due. The filter does not change."""
        told, navigation = self._engine.estimate, self._engine.core.vehicle_state.navigation
        if told is None or navigation is None or now <= told.t:
            return told
        before, at, ahead = self._ahead
        if before is not told or at != now:  # several fields of one frame ask for it
            ahead = navigation.estimate(now)
            self._ahead = told, now, ahead
        return ahead

    def uncertainty(self, now: float) -> float | None:
        """Radius that contains the position with 95 % probability, m; None if unknown."""
        estimate = self.estimate(now)
        if estimate is None or not self._engine.readings["uncertainty"].valid:
            return None
        return _finite(around_95(estimate.covariance))

    def range(self, now: float) -> float | None:
        """Distance from home, m; None if unknown."""
        estimate = self.estimate(now)
        if estimate is None or not self._engine.readings["range"].valid:
            return None
        return math.hypot(estimate.north, estimate.east)

    def _drift(self, now: float) -> tuple[float | None, float | None]:
        """North and east from the last fix to the estimated position, m."""
        estimate, navigation = self.estimate(now), self._engine.core.vehicle_state.navigation
        frame = navigation.frame if navigation is not None else None
        shown = self.shown
        if shown is None or estimate is None or frame is None or self.uncertainty(now) is None:
            return None, None
        north, east = frame.to_local(shown.latitude, shown.longitude)
        return estimate.north - north, estimate.east - east

    def margins(self, now: float) -> dict[str, float | None]:
        """What is left to the limits in force: m, m, min, V; None if the reading is too old."""
        bounds, elapsed = self._engine.bounds, self._engine.mission_time
        depth, volts, far = self._read("depth", now), self._read("battery", now), self.range(now)
        return {
            "depth": None if depth is None else bounds.depth - depth,
            "radius": None if far is None else bounds.radius - far,
            "time": None if elapsed is None else (bounds.time - elapsed) / 60.0,
            "voltage": None if volts is None else volts - bounds.voltage,
        }

    def _read(self, name: str, now: float) -> float | None:
        """A reading's value; None if too old. It ages from the engine's last step on."""
        reading = self._engine.readings[name]
        age = reading.age + max(0.0, now - self._engine.core.now)
        return reading.value if reading.valid and age <= self._vehicle.stale_after else None

    def _without_fix(self, now: float) -> float | None:
        if not self._gps or self.telemetry is None:
            return None
        return now - max(self._deep_at, self.fix.t if self.fix else 0.0)

    def _runs_out(self) -> float | None:
        """Seconds until the voltage limit, by a least-squares line; None if unknown or rising."""
        if len(self._volts) < TREND_LEAST:
            return None
        t0, v0 = (sum(values) / len(self._volts) for values in zip(*self._volts, strict=True))
        spread = sum((t - t0) ** 2 for t, _ in self._volts)
        slope = sum((t - t0) * (v - v0) for t, v in self._volts) / spread
        if slope >= 0.0:
            return None
        left = t0 + (self._engine.bounds.voltage - v0) / slope - self._volts[-1][0]
        return max(0.0, float(left))


def _whose(asker: Peer, commander: Peer | None) -> str:
    if commander is None:
        return "nobody"
    if commander == asker:
        return "asker"
    return "modem" if commander.link == MODEM else "network"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
