"""How soon an X or W reaches the vehicle while somebody else floods the boat's port.

    python tests/bench/bench_flood.py [orders]

`serve` in a process of its own, a board that answers nothing on a pseudo-terminal, one connection
that never stops sending, another that sends X and W in turn.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "worlds"), str(ROOT / "tests" / "onboard")]

from served import read_now, running, silent_board, soon  # noqa: E402
from test_hostile_boat import LOCAL, OTHER, boat, flooding  # noqa: E402

FLOODS = (b"@DU$", b"\xff\x00noise", b"@ZAX", b"@MMF3$")


def main(orders: int = 4) -> dict[str, float]:
    took = [one for frame in FLOODS for one in _through(frame, orders)]
    worst = max(took)
    sys.stdout.write(f"X and W through a flood: {len(took)} orders, worst {worst * 1e3:.0f} ms\n")
    return {"through_flood_s": worst}


def _through(frame: bytes, orders: int) -> list[float]:
    took = []
    with (
        tempfile.TemporaryDirectory() as folder,
        silent_board() as (master, device),
        running(Path(folder), f"serial://{device}") as pi,
        flooding(pi, LOCAL, frame),
        boat(pi, OTHER) as operator,
    ):
        soon(lambda: pi.has_told("floods"), "the flood is told")
        for n in range(orders):
            order = (b"@ZAX0$", b"@ZAWF$")[n % 2]
            while read_now(master):
                pass
            begun, heard = time.perf_counter(), bytearray()
            operator.sendall(order)
            while order not in heard:
                heard += read_now(master)
                time.sleep(0.001)
            took.append(time.perf_counter() - begun)
    return took


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
