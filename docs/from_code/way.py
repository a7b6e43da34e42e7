"""The way of an operator's order through the rooms, drawn from the calls of a runtime that obeys.

A runtime is made, the order's bytes are given to it, and each call from one room into another is
noted once, in order. So the picture shows what the code does.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import FrameType
from typing import Any
from xml.sax.saxutils import escape

from from_code.layers import room_of, svg
from links.base import Rx
from mission.authoring.graph.canvas import Style, width
from mission.model import Tx
from mission.model.shipped import load_vehicle
from mission.onboard.configuration import Configuration
from mission.onboard.runtime.runtime import Runtime
from mission.onboard.store import MemoryStore

BOAT, BOARD = "the boat", "the vehicle"
ORDERS = {"X": b"@ZAX0$", "W": b"@ZAWF$"}
_NAME = Style(12.0, "currentColor")
_LANE, _STEP, _TOP = 165.0, 34.0, 40.0


@dataclass(frozen=True, slots=True)
class Call:
    """``what``: the function, or the bytes."""

    caller: str
    callee: str
    what: str


def order_picture(name: str) -> str:
    """``name``: X or W. Raises LookupError for another."""
    data = ORDERS[name]
    runtime = _runtime()
    calls, sent = traced(lambda: runtime.receive(Rx(1.0, "topside", data, "boat")))
    first, *inner = calls
    told = [Call(first.callee, BOARD, tx.data.decode()) for tx in sent if tx.link == "vehicle"]
    way = [Call(BOAT, first.callee, data.decode()), *inner, *told]
    return _drawn(way, f"The way of {data.decode()} from the boat to the vehicle")


def _runtime() -> Runtime:
    runtime = Runtime(Configuration(), load_vehicle("auv"), MemoryStore())
    runtime.set_navigation(runtime.make_navigation(), 0.0)
    runtime.connected("topside", "boat", 0.0)
    return runtime


def traced(act: Callable[[], list[Tx]]) -> tuple[list[Call], list[Tx]]:
    """Calls from room to room while ``act`` runs, each once, without private ones."""
    calls: dict[Call, None] = {}

    def note(frame: FrameType, event: str, _: Any) -> None:
        name = frame.f_code.co_qualname
        here = _room(frame)
        if event != "call" or not here or "_" in (name[0], name.rpartition(".")[2][0]):
            return
        caller = _caller(frame)
        if caller != here and not name.startswith("<"):
            calls.setdefault(Call(caller, here, name))

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        sent = act()
    finally:
        sys.setprofile(before)
    return list(calls), sent


def _room(frame: FrameType) -> str:
    return room_of(str(frame.f_globals.get("__name__", "")))


def _caller(frame: FrameType) -> str:
    back = frame.f_back
    while back is not None and not _room(back):
        back = back.f_back
    return _room(back) if back is not None else ""


def _drawn(way: list[Call], title: str) -> str:
    lanes = list(dict.fromkeys(room for call in way for room in (call.caller, call.callee)))
    lanes.sort(key=lambda room: (room == BOARD, room != BOAT))
    high = _TOP + _STEP * (len(way) + 1)
    parts = [*_lifelines(lanes, high), *_arrows(lanes, way)]
    return svg(_LANE * len(lanes), high, "".join(parts), title)


def _lifelines(lanes: list[str], high: float) -> Iterator[str]:
    for at, room in enumerate(lanes):
        x = _LANE * (at + 0.5)
        yield f'<path class="lane" d="M{x:g} {_TOP:g}V{high:g}"/>'
        yield f'<rect x="{x - 75:g}" y="4" width="150" height="28" rx="5"/>'
        yield f'<text x="{x:g}" y="22" text-anchor="middle">{escape(room)}</text>'


def _arrows(lanes: list[str], way: list[Call]) -> Iterator[str]:
    for number, call in enumerate(way, 1):
        y = _TOP + _STEP * number
        start, end = (_LANE * (lanes.index(room) + 0.5) for room in (call.caller, call.callee))
        tip = 7.0 if end > start else -7.0
        yield f'<path class="arrow" d="M{start:g} {y:g}H{end:g}m{-tip:g} -4l{tip:g} 4l{-tip:g} 4"/>'
        room = width(call.what, _NAME) / 2 + 4
        middle = min(max((start + end) / 2, room), _LANE * len(lanes) - room)
        yield f'<text class="call" x="{middle:g}" y="{y - 6:g}" text-anchor="middle">'
        yield f"{escape(call.what)}</text>"
