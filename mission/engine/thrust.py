"""Which of a report's actuators are thrusters, whether one of them is on, and which way they push.

What does not live here: what turns on land (watch), what a board's frame says (protocol).
"""

from __future__ import annotations

from protocol.messages import UPWARD, Order, Setpoint, Telemetry

MAINS, THRUSTERS = 2, 5  # of the actuators: the first are the mains; rudders follow
NEUTRAL = 0.02  # share of full thrust
_NONE = Setpoint()


def turns(report: Telemetry) -> bool:
    return any(abs(share) > NEUTRAL for share in (report.actuators or ())[:THRUSTERS])


def with_thrust(report: Telemetry, word: Setpoint | Order | None) -> Telemetry:
    """Where a vehicle does not say what its thrusters do, they are taken to do what they were
    told last: left and right main first, then something that turns while the vertical is held, or
    while it surfaces."""
    if report.actuators is not None:
        return report
    s = UPWARD if word is Order.SURFACE else word if isinstance(word, Setpoint) else _NONE
    vertical = 1.0 if s.depth is not None or s.altitude is not None else s.heave or 0.0
    return report._replace(actuators=(s.surge + s.turn, s.surge - s.turn, vertical))


def downward(report: Telemetry) -> float | None:
    """Share of full thrust of the verticals, downward positive; None where they do not report."""
    verticals = (report.actuators or ())[MAINS:THRUSTERS]
    return -sum(verticals) / len(verticals) if verticals else None
