"""One hour of mission in lock step on one core, against the same loop made of naive parts.

    python tests/bench/bench_hour.py [turns]

1800 @SD, 3600 GPS sentences, some 20 changes of state, dynamics at 20 Hz; transitions and filterpy
in both loops, bytes through the real decoders of each. Then the shares of the rooms in ours, and
what the black box adds, and what it takes of a disk.
"""

from __future__ import annotations

import cProfile
import pstats
import statistics
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "bench")]

from naive import NaiveFlight  # noqa: E402

from links.simulated.settings import Settings  # noqa: E402
from mission.authoring.compiler.compiler import compile_mission  # noqa: E402
from mission.authoring.language import digest, parse  # noqa: E402
from mission.model import Mission  # noqa: E402
from mission.model.shipped import load_vehicle  # noqa: E402
from mission.model.vehicle import Vehicle  # noqa: E402
from mission.onboard.blackbox import BlackBox  # noqa: E402
from mission.onboard.blackbox.closed import close_recording  # noqa: E402
from mission.onboard.blackbox.parts import parts_of  # noqa: E402
from mission.onboard.runtime.records import Recorder  # noqa: E402
from mission.verification.simulation.flight import fly  # noqa: E402
from protocol.vehicles import codec  # noqa: E402

HOUR, SLICES = 3600.0, 16
MISSION = """mission hour vehicle auv
home 30.2874595 120.1535765
safety radius 2000 time 120min depth 30
assume current 0.1
dive: ZAS8 heading 90 ZAF4 until depth >= 7.5 timeout 2min
repeat 9 rows:
  out: heading 90 ZAF4 until elapsed >= 190s or altitude < 1.5 timeout 200s
  back: heading 270 ZAF4 until elapsed >= 190s or altitude < 1.5 timeout 200s
end
up: surface timeout 2min
"""
SETTINGS = Settings(sentences=("GGA",))  # one a second: 3600
ROOMS = {
    "plant and boards": ("links/simulated",),
    "wire": ("protocol/", "pynmea2", "crcmod"),
    "navigation": ("mission/navigation", "filterpy", "numpy"),
    "machine and guards": (
        "transitions", "mission/engine/machine", "mission/engine", "mission/engine/variables",
        "mission/engine/limits", "mission/legs",
    ),
    "black box": ("mission/onboard/runtime/records", "mission/onboard/blackbox", "mcap"),
}  # fmt: skip


def quartiles(values: list[float]) -> tuple[float, float, float]:
    """Of one value: that value, which `statistics.quantiles` refuses."""
    low, middle, high = statistics.quantiles(values, n=4) if len(values) > 1 else values * 3
    return low, middle, high


def main(turns: int = 32) -> dict[str, float]:
    """The naive hour is cut into slices about as long as a flight of ours, and they take turns:
    whatever else the machine does meets all of them alike. So each turn has a ratio of its own,
    and their median is what counts. ValueError of no turn at all."""
    if turns < 1:
        raise ValueError(f"{turns} turns: one or more are needed")
    say = sys.stdout.write
    mission, vehicle = parse(MISSION), load_vehicle("auv")
    chart = compile_mission(mission, vehicle, digest(mission))
    words = codec("auv", "documented", {}).encode
    ours, theirs, boxed = [], [], []
    _timed(mission, vehicle)  # imports, and code that has been run before
    for n in range(turns):
        if n % SLICES == 0:
            naive = NaiveFlight(chart, vehicle, words, SETTINGS)
        ours.append(_timed(mission, vehicle))
        theirs.append(_sliced(naive, (n % SLICES + 1) * HOUR / SLICES))
        boxed.append(_boxed(mission, vehicle))
    naive.fly(2 * HOUR)
    assert naive.state == "over", naive.state
    one, other = statistics.median(ours), statistics.median(theirs)
    say(f"one hour of mission, medians of {turns} turns; {naive.left} changes of state\n")
    say(f"  naive parts      {other * HOUR:6.2f} s   {1 / other:7.0f} times real time\n")
    say(f"  this engine      {one * HOUR:6.2f} s   {1 / one:7.0f} times real time\n")
    ratios = [naive / own for naive, own in zip(theirs, ours, strict=True)]
    low, ratio, high = quartiles(ratios)
    added = statistics.median(full / own for full, own in zip(boxed, ours, strict=True))
    say(f"  ratio            {ratio:6.1f}     half of the turns ")
    say(f"{low:.1f} to {high:.1f}\n")
    say(f"  of the minima    {min(theirs) / min(ours):6.1f}\n")
    say(f"  with black box   {added:6.2f}     times that (1.5 at most wanted)\n")
    growing, closed = _sizes(mission, vehicle)
    say(f"  its black box    {growing:6.1f} MB, {closed:.1f} MB once it is closed\n")
    _shares(mission, vehicle)
    return {"hour_ratio": ratio, "black_box_ratio": added}


def _sliced(naive: NaiveFlight, until: float) -> float:
    """Process time per second of mission, of the naive flight from where it is."""
    since, begun = naive.now, time.process_time()
    naive.fly(until)
    return (time.process_time() - begun) / (naive.now - since)


def _timed(mission: Mission, vehicle: Vehicle, recorder: Recorder | None = None) -> float:
    """Process time per second of mission."""
    begun = time.process_time()
    flight = fly(mission, vehicle, "documented", settings=SETTINGS, recorder=recorder)
    assert flight.outcome == "completed", flight.reason
    return (time.process_time() - begun) / flight.mission_time


def _boxed(mission: Mission, vehicle: Vehicle) -> float:
    with tempfile.TemporaryDirectory() as folder:
        box = BlackBox(Path(folder) / "hour.mcap")
        spent = _timed(mission, vehicle, box)
        box.close()
    return spent


def _sizes(mission: Mission, vehicle: Vehicle) -> tuple[float, float]:
    """MB of an hour, as its parts grow and once they are closed."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hour.mcap"
        box = BlackBox(path)
        flight = fly(mission, vehicle, "documented", settings=SETTINGS, recorder=box)
        box.close()
        growing = sum(part.stat().st_size for part in parts_of(path))
        close_recording(path)
        closed = sum(part.stat().st_size for part in parts_of(path))
    hours = flight.mission_time / HOUR
    return growing / hours / 1e6, closed / hours / 1e6


def _shares(mission: Mission, vehicle: Vehicle) -> None:
    """Of the flight with its black box, by cProfile: it favours rooms of few large functions."""
    profile = cProfile.Profile()
    profile.runcall(_boxed, mission, vehicle)
    times = dict.fromkeys([*ROOMS, "the rest"], 0.0)
    for (file, _, _), (_, _, own, _, callers) in pstats.Stats(profile).stats.items():
        if file == "~":  # a builtin's time belongs to who called it
            for (caller, _, _), entry in callers.items():
                times[_room(caller)] += entry[2]
        else:
            times[_room(file)] += own
    total = sum(times.values())
    for name, own in times.items():
        sys.stdout.write(f"    {name:20} {100 * own / total:5.1f} %\n")


def _room(file: str) -> str:
    path = file.replace("\\", "/")
    return next((n for n, parts in ROOMS.items() if any(p in path for p in parts)), "the rest")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
