"""From kill -9 in a mission to the first upward word of the next program, with the service manager's pause.

    python tests/bench/bench_survival.py [TURNS]

``first_up_s`` is the worst by the wall's clock, on this machine with whatever else it does;
``computing_s`` the least of the processor's time until then: times the slowness of a Pi (4 to 8)
and with the pause of one second it must stay below ten seconds, too.
"""

from __future__ import annotations

import json
import random
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "worlds"), str(ROOT / "tests" / "onboard")]

SPEED = 8.0
TURNS = 3


def main(turns: int = TURNS) -> dict[str, float]:
    from test_survival import killed_in_a_mission

    chance = random.Random(6)
    took = []
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(turns):
            mine = Path(folder) / str(turn)
            mine.mkdir()
            took.append(killed_in_a_mission(mine, turn, SPEED, chance.uniform(0.0, 1.0)))
    return {
        "first_up_s": max(one.first_up for one in took),
        "computing_s": min(one.computing for one in took),
    }


if __name__ == "__main__":
    sys.stdout.write(json.dumps(main(*map(int, sys.argv[1:2]))) + "\n")
