"""Record the black boxes of ``recorded`` anew: python tests/analysis/record.py. Who changes a rule of
flight on purpose does so, and reads what the new ones tell.

    short-time         an operator allows a mission less time than it needs
    heavy-then-ended   water comes in, W, and 2 s later the program is told to end
    begun-again        the life of the program behind that
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from links.simulated.settings import FaultEvent
from mission.onboard.blackbox import BlackBox, close_recording
from mission.verification.campaign.disturbances import Act, Disturbance
from mission.verification.campaign.draw import Drawn, Plan, stage
from mission.verification.campaign.faults import fly_plan

RECORDED = Path(__file__).parent / "recorded"
NEVER = 1e6  # s


def said(after: float, data: bytes) -> Disturbance:
    return Disturbance(after, Act.SAY, data, "topside", "boat")


def short_time() -> Plan:
    plan = stage("short_time", 0)
    sea = replace(plan.settings.sea, current=(0.159, 4.254))
    return replace(
        plan,
        profile="as-built",
        vehicle_seed=1855670972,
        heading=3.787,
        settings=replace(plan.settings, sea=sea, faults=()),
        incidents=(Drawn("short_time", 0.0, (said(41.0, b"@SP,2000,2,100,10,$"),)),),
    )


def ended() -> Plan:
    plan = stage("ended", 0)
    sea = replace(plan.settings.sea, current=(0.47, 1.247))
    heavy = FaultEvent("heavy", 40.7, NEVER, 36.9)
    weak = FaultEvent("right_main_weak", 38.8, 67.0, 0.225)
    end = Disturbance(40.66, Act.END, b"", "topside", "boat")
    return replace(
        plan,
        profile="documented",
        vehicle_seed=1093245503,
        heading=math.radians(56.2),
        settings=replace(plan.settings, sea=sea, faults=(heavy, weak)),
        incidents=(Drawn("ended", 0.0, (said(38.66, b"@ZAWF$"), end)),),
    )


def record(plan: Plan, *names: str) -> None:
    """One box for each life of the program."""
    boxes: list[BlackBox] = []

    def next_box() -> BlackBox:
        path = RECORDED / f"{names[len(boxes)]}.mcap"
        path.unlink(missing_ok=True)
        boxes.append(BlackBox(path))
        return boxes[-1]

    recorder: Callable[[], BlackBox] = next_box
    fly_plan(plan, plan.vehicle, recorder)
    for box in boxes:
        box.close()
        close_recording(box.path)


if __name__ == "__main__":
    record(short_time(), "short-time")
    record(ended(), "heavy-then-ended", "begun-again")
