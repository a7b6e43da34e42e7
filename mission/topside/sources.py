"""The sources of `auvmission watch`: each fills a Watched until it is stopped.

    monitor   serve's own monitor                       frames   the operator's port: @AE, @VS, @AR
    playback  a recording, finished or just simulated, run again

A source never raises into the view: ``problem`` holds the error. What does not live here: how it is
shown (panels, watch), what a recording is (the command).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, Protocol

from links.base import LinkError
from mission.topside.console import observe
from mission.topside.looking import Looked, look
from mission.topside.monitor import NoMonitor, Watched, wish
from mission.topside.port import Port
from mission.topside.showing import as_object
from mission.topside.underwater import PREFIX
from mission.topside.upload import OperatorError

AGAIN_S = 2.0  # after a failure
ASK_S, ASK_UNDER_WATER_S = 1.0, 15.0  # R11
STEP_S = 0.2
MARGINS = ("depth_m", "radius_m", "time_min", "voltage_v")  # keys of as_object; None without @AE


class Source:
    """Runs in its own thread. ``live``: a vehicle that can be commanded. ``port``: where it is
    asked, by looks that break off for orders."""

    def __init__(
        self, fill: Callable[[Source], None], live: bool, port: Port | None = None
    ) -> None:
        self.watched, self.problem, self.live, self.port = Watched(), "", live, port
        self.stopped = threading.Event()
        self._fill = fill

    def run(self) -> None:
        while not self.stopped.is_set():
            try:
                self._fill(self)
                self.problem = ""
            except (LinkError, NoMonitor, OperatorError, ValueError) as error:
                self.problem = str(error)
            if not self.live:
                return
            self.stopped.wait(AGAIN_S)


def from_monitor(url: str, most: int = 16_000, past: str = "") -> Source:
    """``most``: bytes of a frame; on a slow link they set its delay. ``past``: "before" for the
    earlier values."""

    def fill(source: Source) -> None:
        source.watched.connected()
        for frame in observe(url, wish(most=most, past=past), source.watched):
            if frame is not None:
                source.problem = ""
            if source.stopped.is_set():
                return

    return Source(fill, live=True)


def from_frames(url: str) -> Source:
    under_water, port = url.startswith(PREFIX), Port(url)

    def fill(source: Source) -> None:
        began = time.monotonic()
        while not source.stopped.is_set():
            found: list[Looked] = []
            port.look(look(found.append, under_water=under_water, now=time.monotonic))
            now = time.monotonic()
            source.watched.take(frame_of(found[0], now - began), now)
            source.problem = ""
            source.stopped.wait(ASK_UNDER_WATER_S if under_water else ASK_S)

    return Source(fill, live=True, port=port)


def frame_of(looked: Looked, t: float) -> dict[str, Any]:
    """Return a look at the operator's port as a frame of the monitor at ``t``."""
    told = as_object(looked)
    place = told["estimate"] or told
    margins = told["margins"] or dict.fromkeys(MARGINS)
    ellipse = told["estimate"].get("within_m") if told["estimate"] else None
    state = {
        "state": told["state"],
        "alarms": told["alarms"],
        "leg": told["leg"],
        "depth": told["depth_m"],
        "latitude": place["latitude"],
        "longitude": place["longitude"],
        "place": "estimate" if told["estimate"] else "last fix",
        "ellipse": None if ellipse is None else [ellipse, ellipse, 0],
        "report_at": _before(t, looked.report_age),
        "fix_at": _before(t, looked.fix_age),
        "setpoint": told["setpoint"],
        "commander": told["commander"],
        **{f"to_{name.partition('_')[0]}": [left, None] for name, left in margins.items()},
        "mission": told["digest"],
        "altitude": told["altitude_m"],
        "heading": told["heading_deg"],
        "battery": told["battery_v"],
    }
    track = [[round(t, 1), place["latitude"], place["longitude"], told["depth_m"]]]
    return {
        "n": 0,
        "t": t,
        "state": state,
        "track": track if place["latitude"] is not None else [],
    }


def _before(t: float, age: float | None) -> float | None:
    return None if age is None else t - age


class Played(Protocol):
    """A recording that can be run again."""

    @property
    def over(self) -> bool: ...

    def until(self, t: float) -> bytes: ...

    def answer(self, said: bytes) -> None: ...


def from_recording(played: Played, speed: float, begin: float = 0.0) -> Source:
    """Play at ``speed`` times real time, from the engine's time ``begin`` on."""

    def fill(source: Source) -> None:
        zero = time.monotonic()
        while not source.stopped.is_set():
            now = time.monotonic()
            frame = played.until(begin + (now - zero) * speed)
            _, answers = source.watched.receive(frame, now)
            if answers:
                played.answer(answers)
            if played.over and not frame:
                source.problem = "the recording is over"
                source.stopped.wait()
            source.stopped.wait(STEP_S)

    return Source(fill, live=False)
