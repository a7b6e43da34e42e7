"""`python -m tests.sea [SCENE...] [--seed N] [--draw COUNT] [--wire]`: fly, and say what became of it."""

from __future__ import annotations

import argparse
import fnmatch
import sys

from tests.sea.fly import drawn, fly
from tests.sea.scene import Draw
from tests.sea.scenes import PAIRS, SCENES


def main() -> int:
    """Fly the scenes whose names match; 0 when every law held in each."""
    parser = argparse.ArgumentParser(prog="python -m tests.sea")
    parser.add_argument("scene", nargs="*", default=["*"], help="names, with * as in a shell")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--draw", type=int, default=0, help="so many scenes at random, from the seed on"
    )
    parser.add_argument(
        "--wire", action="store_true", help="print the words to the board, and serve's output"
    )
    parser.add_argument(
        "--real", action="store_true", help="in the machine's time, with no clock touched"
    )
    parser.add_argument("--list", action="store_true")
    choice = parser.parse_args()
    scenes = tuple(
        s for s in (*SCENES, *PAIRS) if any(fnmatch.fnmatch(s.name, p) for p in choice.scene)
    )
    if choice.list:
        for scene in scenes:
            sys.stdout.write(f"{scene.name:28} {scene.why}\n")
        return 0
    plain = Draw(world={"real": choice.real})
    flights = [(scene, choice.seed, plain) for scene in scenes]
    if choice.draw:
        seeds = range(choice.seed, choice.seed + choice.draw)
        flights = [(scene, seed, draw) for seed in seeds for scene, draw in [drawn(scenes, seed)]]
    failed = 0
    for scene, seed, draw in flights:
        verdict = fly(scene, seed, draw)
        failed += bool(verdict.wrong)
        sys.stdout.write(f"{verdict.line()}\n")
        if choice.wire:
            sys.stdout.write("\n".join([str(verdict.notes), *verdict.words, verdict.output, ""]))
        sys.stdout.flush()
    sys.stdout.write(f"{len(flights) - failed} of {len(flights)} came home by every law\n")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
