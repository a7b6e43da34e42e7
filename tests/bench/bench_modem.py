"""A mission of 60 lines over the simulated modem: batches, line by line, and the limit.

    python tests/bench/bench_modem.py [flights per cell]

The limit is what no stop and wait in whole blocks beats on average: every line once, in blocks of the
length b that suits the wrong bits best, each as often as it takes; the N bursts of at most 3200 bytes
that this is, each as often as it takes to come, the last as often as it takes to be answered; after
each of them the way through the water and the report, or R1's time where none comes.

    came(n) = (1 - loss) (1 - errors)^(8 (n + 7))       both = came(4) came(A)
    E = (N - 1) / (1 - loss) + 1 / both
    limit = min over b of  8 L (b + 7) / b / rate / came(b)
          + E both (2 range / sound speed + 8 (A + 7) / rate)
          + E (1 - both) R1's time of question and report

L bytes of lines as frames, A of the shortest report, 4 of a question, 7 of an envelope; b <= L.
"""

from __future__ import annotations

import statistics
import sys
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "protocol")]

from modem_rig import (  # noqa: E402
    OneLineUpload,
    Sender,
    Vehicle,
    acoustics_of,
    digest,
    fly,
)

from links.acoustic import Water  # noqa: E402
from protocol.arq import Acoustics  # noqa: E402
from protocol.batch import BatchUpload, Stored  # noqa: E402
from protocol.modem import MOST, OVERHEAD  # noqa: E402

LINES = [
    "mission harbour-survey vehicle auv sum 01234567",
    *(f"leg{n}: heading {n} ZAF6 until travelled >= {100 + n} timeout 4min" for n in range(59)),
]
CONTENT = sum(8 + len(line) for line in LINES)
QUESTION, REPORT = 4, len("@AR,ready,60,60,,0123456789abcdef,,$")
WATERS = [
    Water(1000.0, bit_rate, loss, errors)
    for bit_rate in (300.0, 1000.0, 5000.0)
    for loss in (0.0, 0.1, 0.2, 0.4)
    for errors in (0.0, 1e-5, 1e-4)
]
FLIGHTS = 200  # of 20, the median of the worst row is anything from 1.3 to 1.8 times the limit
LINE_BY_LINE = 20  # flights; only to compare with
HEAD = "bit/s loss  errors |  limit s   batch s  lines s |  batch B  lines B | x sooner  x limit"


def main(flights: int = FLIGHTS) -> dict[str, float]:
    say = sys.stdout.write
    say(f"{len(LINES)} lines, {CONTENT} bytes as frames; 1 km; medians of {flights} flights, ")
    say(f"line by line of {LINE_BY_LINE} at most\n{HEAD}\n")
    ratios = []
    for water in WATERS:
        text, ratio = row(water, flights)
        say(f"{text}\n")
        ratios.append(ratio)
    say(f"the worst row: {max(ratios):.2f} times the limit\n")
    return {"upload_ratio": max(ratios)}


def row(water: Water, flights: int) -> tuple[str, float]:
    """A line of the table, and its last figure."""
    batch, size = medians(lambda at: BatchUpload(LINES, digest(LINES), at), water, flights)
    few = min(flights, LINE_BY_LINE)
    single, single_size = medians(lambda at: OneLineUpload(LINES, at), water, few)
    limit = limit_of(water)
    text = (
        f"{water.bit_rate:5.0f} {water.loss:4.0%} {water.bit_error_rate:7.0e} |"
        f" {limit:8.1f} {batch:9.1f} {single:8.1f} | {size:8.0f} {single_size:8.0f} |"
        f" {single / batch:8.1f} {batch / limit:8.2f}"
    )
    return text, batch / limit


def medians(
    sender_of: Callable[[Acoustics], Sender], water: Water, flights: int
) -> tuple[float, float]:
    """Seconds and bytes of an upload; the flights differ by their seed alone."""
    flown = []
    for seed in range(flights):
        sender, vehicle = sender_of(acoustics_of(water)), Vehicle()
        flown.append(fly(sender, vehicle, water, seed))
        assert sender.outcome == Stored(), (water, seed, sender.outcome)
        assert vehicle.stored == tuple(LINES)
    seconds = statistics.median(flight.seconds for flight in flown)
    return seconds, statistics.median(flight.size for flight in flown)


def limit_of(water: Water) -> float:
    """Seconds; the formula above."""

    def came(content: int) -> float:
        bits = 8 * (content + OVERHEAD)
        return (1.0 - water.loss) * (1.0 - water.bit_error_rate) ** bits

    lines = min(CONTENT / b * water.airtime(b + OVERHEAD) / came(b) for b in range(1, CONTENT + 1))
    both, bursts = came(QUESTION) * came(REPORT), -(-CONTENT // MOST)
    exchanges = (bursts - 1) / (1.0 - water.loss) + 1.0 / both
    answered = 2.0 * water.delay + water.airtime(REPORT + OVERHEAD)
    wait = acoustics_of(water).patience(QUESTION, REPORT)
    return lines + exchanges * (both * answered + (1.0 - both) * wait)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
