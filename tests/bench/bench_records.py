"""What recording costs: the records of one hour of mission, made and stored as serve does it.

    python tests/bench/bench_records.py [turns]

An hour of `bench_hour` is flown once and its records are kept. Timed is the processor time of making
the records of bytes and estimates anew, of packing all, and of storing them ten times a second, on
the disk of the temporary folder, each store synced. What counts is the least of the turns: whatever else the machine does only adds.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "bench")]

from bench_hour import MISSION, SETTINGS  # noqa: E402

from mission.authoring.language import parse  # noqa: E402
from mission.model import Record  # noqa: E402
from mission.model.shipped import load_vehicle  # noqa: E402
from mission.onboard.blackbox import FLUSH_S, BlackBox  # noqa: E402
from mission.onboard.runtime import records as rec  # noqa: E402
from mission.verification.simulation.flight import fly  # noqa: E402

HOUR = 3600.0
Known = tuple[object, ...]
MAKERS: Mapping[str, tuple[Callable[[Record], Known], Callable[..., Record]]] = {
    rec.RX: (lambda record: (rec.read_rx(record), record.t), rec.rx_record),
    rec.TX: (lambda record: (rec.read_tx(record),), rec.tx_record),
    rec.ESTIMATE: (lambda record: (rec.estimate_of(record.payload),), rec.estimate_record),
    rec.STEP: (lambda record: (rec.step_of(record.payload),), rec.step_record),
}


def main(turns: int = 5) -> dict[str, float]:
    recorder = rec.ListRecorder()
    flight = fly(parse(MISSION), load_vehicle("auv"), "documented", settings=SETTINGS,
                 recorder=recorder)  # fmt: skip
    hours, records = flight.mission_time / HOUR, recorder.records
    made = min(_made(records) for _ in range(turns)) / hours
    packed = min(_kept(records, False) for _ in range(turns)) / hours
    stored = min(_kept(records, True) for _ in range(turns)) / hours - packed
    say = sys.stdout.write
    say(f"{len(records) / hours:.0f} records an hour: made {made:.3f} s, packed {packed:.3f} s, ")
    say(f"stored and synced {stored:.3f} s of a core (least of {turns})\n")
    return {"record_s": made + packed, "store_s": stored}


def _made(records: Sequence[Record]) -> float:
    """s of a core, of the kinds that are made over and over."""
    known = [(MAKERS[r.kind][1], MAKERS[r.kind][0](r)) for r in records if r.kind in MAKERS]
    begun = time.process_time()
    for make, values in known:
        make(*values)
    return time.process_time() - begun


def _kept(records: Sequence[Record], store: bool) -> float:
    """s of a core for packing, and where wanted for storing ten times a second."""
    with tempfile.TemporaryDirectory() as folder:
        box, due = BlackBox(Path(folder) / "b.mcap", shell=True), 0.0
        begun = time.process_time()
        for record in records:
            if record.t >= due:
                due, data = record.t + FLUSH_S, box.take()
                if store:
                    box.store(data, True)
            box.record(record)
        spent = time.process_time() - begun
        box.close()
    return spent


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
