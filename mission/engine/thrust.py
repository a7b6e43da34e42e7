"""Which of a report's actuators are thrusters, and whether one of them is on.

What does not live here: what turns on land (watch), what a board's frame says (protocol).
"""

from __future__ import annotations

from protocol.messages import Telemetry

MAINS, THRUSTERS = 2, 5  # of the actuators: the first are the mains; rudders follow
NEUTRAL = 0.02  # share of full thrust


def turns(report: Telemetry) -> bool:
    return any(abs(share) > NEUTRAL for share in (report.actuators or ())[:THRUSTERS])
