"""Which of a report's actuators are thrusters, whether one of them is on, and which way they push.

What does not live here: what turns on land (watch), what a board's frame says (protocol).
"""

from __future__ import annotations

from protocol.messages import UPWARD, Order, Setpoint, Telemetry

MAINS, THRUSTERS = 2, 5  # of the actuators: mains before 2, verticals before 5, then rudders
NEUTRAL = 0.02  # share of full thrust
_DIVES = 0.5  # share of full thrust down, as reported: it would not stay at the surface
_NONE = Setpoint()


def turns(report: Telemetry) -> bool:
    return any(abs(share) > NEUTRAL for share in (report.actuators or ())[:THRUSTERS])


def with_thrust(report: Telemetry, word: Setpoint | Order | None) -> Telemetry:
    """The report with actuators. If a vehicle does not report its thrusters, they are assumed to do
    what was last commanded: left and right main, then a vertical that is on while depth or altitude
    is held, or while it surfaces."""
    if report.actuators is not None:
        return report
    s = UPWARD if word is Order.SURFACE else word if isinstance(word, Setpoint) else _NONE
    vertical = 1.0 if s.depth is not None or s.altitude is not None else s.heave or 0.0
    return report._replace(actuators=(s.surge + s.turn, s.surge - s.turn, vertical))


def downward(report: Telemetry) -> float | None:
    """Share of full thrust of the verticals, downward positive; None if they are not reported."""
    verticals = (report.actuators or ())[MAINS:THRUSTERS]
    return -sum(verticals) / len(verticals) if verticals else None


def dives(report: Telemetry) -> bool:
    """Whether the verticals, in their frame, push down so hard that no surface is kept (R7)."""
    return (downward(report) or 0.0) >= _DIVES
