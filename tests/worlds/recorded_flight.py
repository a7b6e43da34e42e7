"""A flight of a shipped mission in a current, as its black box has it."""

from __future__ import annotations

from pathlib import Path

from links.simulated.settings import parse_settings
from mission.authoring.prepare import prepare
from mission.model.shipped import missions_folder
from mission.onboard.blackbox import BlackBox
from mission.verification.simulation.flight import fly

CURRENT = "current=0.2@70"
NOTES = {"seed": "5", "sea": CURRENT}


def recorded(path: Path, mission: str, *settings: str) -> Path:
    """``mission``: a file of missions/. The box is closed, its parts are not."""
    prepared = prepare(missions_folder() / mission)
    box = BlackBox(path, wall=1.75e9)
    fly(prepared.mission, prepared.vehicle, seed=int(NOTES["seed"]),
        settings=parse_settings([CURRENT, *settings]), recorder=box)  # fmt: skip
    box.close()
    return path
