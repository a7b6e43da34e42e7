"""Control of depth and heading on the Pi, for a board that takes efforts alone (R17).

    report --> filter --> error --> gain, rate, integral, trim --> effort, within its bound

- A reading that its report marks doubtful counts as missing.
- A reading that the vehicle cannot have reached is an outlier, and left out. If all readings of a
  second are outliers, the filter restarts: a fast board repeats one wrong value of its sensor.
- If the report is older than 0.5 s, the effort is neutral.
- If the error grows by 0.5 m, or 30 degrees, within 5 s of the same set, in every reading of a
  second, the vehicle does not behave as its file says: the effort is neutral, and the set is
  refused. Growth under a set that was given up, or while neutral, does not count for the next set.

The output depends on the recorded reports and their times alone.

What does not live here: the gains (vehicle file), who confirms axes and signs (doctor).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

from mission.model.vehicle import CLOSED_S, AxisLoop, OuterLoop
from mission.navigation.health import CHANNELS, doubted
from protocol.messages import Order, Setpoint, Telemetry

GROWS_S, LASTS_S = 5.0, 1.0
GROWN = {"depth": 0.5, "heading": math.radians(30.0)}  # m, rad
_SMOOTH_S = 0.3  # time constant of the filter
_GAP_S = 1.0  # a longer gap restarts the filter
_LEAP = {"depth": 1.0, "heading": math.radians(30.0)}  # m, rad beyond the possible movement
_EFFORTS = {"depth": "heave", "heading": "turn"}


class _Window:
    """The minimum of the last ``seconds``; with ``sign`` -1 the maximum. Values that can no longer
    be the minimum are forgotten, so that each value is handled once."""

    def __init__(self, seconds: float, sign: float = 1.0) -> None:
        self._seconds, self._sign = seconds, sign
        self._kept: deque[tuple[float, float]] = deque()  # s; value times sign, rising

    def take(self, t: float, value: float) -> float:
        kept, signed = self._kept, self._sign * value
        while kept and kept[-1][1] >= signed:
            kept.pop()
        kept.append((t, signed))
        while kept[0][0] < t - self._seconds:
            kept.popleft()
        return self._sign * kept[0][1]

    def shift(self, by: float) -> None:
        self._kept = deque((t, signed + self._sign * by) for t, signed in self._kept)

    def clear(self) -> None:
        self._kept.clear()


class _Axis:
    """One axis: an alpha-beta filter (Kalata 1984: beta = alpha^2 / (2 - alpha)) and a PID loop.
    ``heard``: when its last reading that is no outlier was reported."""

    def __init__(self, name: str, gains: AxisLoop) -> None:
        self.name, self._gains, self._circular = name, gains, name == "heading"
        self.heard = -math.inf
        self._value = self._rate = self._sum = 0.0
        self._leaps = False  # the last reading was an outlier
        self._wanted: float | None = None
        self._error: float | None = None  # the last one, without sign
        self._least, self._most = _Window(LASTS_S), _Window(LASTS_S, -1.0)
        self._from = _Window(GROWS_S + LASTS_S)  # least of the maxima of a second
        self._resumes = False
        self.effort = 0.0

    def hold(self, wanted: float | None) -> None:
        if wanted != self._wanted:
            self._wanted, self._sum, self.effort = wanted, 0.0, 0.0
            self.forget()
            if wanted is not None:
                self._control(self._apart(wanted, self._value), 0.0)

    def report(self, t: float, value: float) -> str:
        """Take in a reading. Return why the axis is no longer held, "" if it is."""
        dt = t - self.heard
        if dt <= 0.0:
            return ""
        before, self._leaps = self._leaps, self._leapt(dt, value)
        if self._leaps:
            return ""
        self._resumes = self._resumes and not before  # was reported: it counts as error now
        self._filter(dt, value)
        self.heard = t
        if self._wanted is None:
            return ""
        error = self._apart(self._wanted, self._value)
        self._control(error, min(dt, _GAP_S))
        return self._grown(t, abs(error))

    def forget(self) -> None:
        """Forget the errors so far: growth counts from here on."""
        self._error = None
        for window in (self._least, self._most, self._from):
            window.clear()

    def resume(self) -> None:
        """Growth until the next report does not count, because the effort was neutral."""
        self._resumes = True

    def _leapt(self, dt: float, value: float) -> bool:
        """Whether the reading is an outlier, to be left out."""
        off = abs(self._apart(value, self._value + self._rate * dt))
        return dt <= _GAP_S and off > _LEAP[self.name] + CHANNELS[self.name].rate * dt

    def _filter(self, dt: float, value: float) -> None:
        if dt > _GAP_S:
            self._value, self._rate = value, 0.0
            return
        alpha = 1.0 - math.exp(-dt / _SMOOTH_S)
        ahead = self._value + self._rate * dt
        off = self._apart(value, ahead)
        self._value = ahead + alpha * off
        self._rate += alpha * alpha / (2.0 - alpha) * off / dt

    def _control(self, error: float, dt: float) -> None:
        g = self._gains
        swift = g.trim + g.gain * error - g.rate * self._rate
        if abs(swift + self._sum) < g.most:  # no windup at the bound
            added = self._sum + g.integral * error * dt
            self._sum = max(-g.integral_most, min(g.integral_most, added))
        self.effort = max(-g.most, min(g.most, swift + self._sum))

    def _grown(self, t: float, error: float) -> str:
        """Compare the least error of the last second with the greatest of a second before it, so
        that neither one wrong reading nor the return from it is growth. Return the fault or ""."""
        if self._resumes and self._error is not None:
            for window in (self._least, self._most, self._from):
                window.shift(error - self._error)
        self._resumes, self._error = False, error
        grown = self._least.take(t, error) - self._from.take(t, self._most.take(t, error))
        if grown < GROWN[self.name]:
            return ""
        told = f"{math.degrees(grown):.0f} deg" if self._circular else f"{grown:.1f} m"
        return f"{self.name} is not held: {told} farther off within {GROWS_S:g} s"

    def _apart(self, one: float, other: float) -> float:
        return math.remainder(one - other, math.tau) if self._circular else one - other


class LoopCloser:
    """The loops of one board. Positive efforts are down, and to starboard."""

    def __init__(self, loop: OuterLoop) -> None:
        self._axes = {
            "depth": _Axis("depth", loop.depth),
            "heading": _Axis("heading", loop.heading),
        }
        self._set: Setpoint | None = None
        self.fault = ""  # why the set is given up

    def open(self, command: Setpoint | Order) -> Setpoint | Order:
        """Return the setpoint without the axes that are closed here."""
        if not isinstance(command, Setpoint):
            return command
        return replace(command, depth=None, heading=None)

    def hold(self, command: Setpoint | Order) -> None:
        """Hold this setpoint until the next. A repeated setpoint keeps its errors, unless it was
        given up."""
        if self.fault:
            self._forget()
        self._set, self.fault = (command if isinstance(command, Setpoint) else None), ""
        for name, axis in self._axes.items():
            axis.hold(None if self._set is None else getattr(self._set, name))

    def report(self, report: Telemetry) -> None:
        if self._is_blind(report.t):
            for axis in self._axes.values():
                axis.resume()
        doubtful = doubted(report)
        for name, axis in self._axes.items():
            value = None if name in doubtful else getattr(report, name)
            if value is not None and (why := axis.report(report.t, value)):
                self.fault = self.fault or why

    def closed(self, command: Setpoint | Order, now: float) -> Setpoint | Order:
        """Return the setpoint as efforts, for a board that takes nothing else."""
        held = self._held()
        if not isinstance(command, Setpoint) or not held:
            return command
        if self.fault or self._is_blind(now):
            return Order.STOP  # neutral, and nothing that the board holds by itself
        efforts = {_EFFORTS[name]: self._axes[name].effort for name in held}
        heave, turn = efforts.get("heave", command.heave), efforts.get("turn", command.turn)
        return replace(command, depth=None, heading=None, heave=heave, turn=turn)

    def _is_blind(self, now: float) -> bool:
        """Whether a reading that a held axis needs is too old."""
        return any(now - self._axes[name].heard > CLOSED_S for name in self._held())

    def _forget(self) -> None:
        for axis in self._axes.values():
            axis.forget()

    def _held(self) -> list[str]:
        s = self._set
        return [] if s is None else [n for n in self._axes if getattr(s, n) is not None]
