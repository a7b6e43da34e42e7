"""Find the value of every axis in every leg: an omitted axis keeps its value.

A value is carried along the ways between legs until a leg states the axis. Errors are:

    a leg omits an axis, and two different values reach it
    turn and heading in one leg
    a leg omits an axis that the leg before steered by itself (a goto's heading): its value then is
    unknown

    (surge, turn) | heading | ("depth" | "altitude" | "heave", value) | (pitch, roll)
    ("depth", value, "altitude", value): that depth, never below that altitude
    each output by its name; None: safe

The effort is linear in legs and ways, since each leg keeps at most two values of an axis (two are
an error already). What does not live here: the ways (ways.py), what a vehicle can do (abilities).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from mission.authoring.compiler.refusing import refused
from mission.legs import LEGS
from mission.model import Axis, Leg, LegKind, Set, Setting, Where
from mission.model.diagnostics import Diagnostic
from mission.model.texts import NEVER_BELOW
from mission.model.units import GEARS
from protocol.messages import Setpoint

_AXIS_OF = {
    "surge": Axis.HORIZONTAL,
    "turn": Axis.HORIZONTAL,
    "heading": Axis.HEADING,
    "depth": Axis.VERTICAL,
    "altitude": Axis.VERTICAL,
    "heave": Axis.VERTICAL,
    "pitch": Axis.ATTITUDE,
    "roll": Axis.ATTITUDE,
}
_VERTICAL = ("depth", "altitude", "heave")
_STEERED = ("steered",)  # the leg before steered it by itself

Value = tuple[float | str, ...] | None  # None: not controlled
Kept = Axis | str  # an axis, or the name of an output
INITIAL: Mapping[Kept, Value] = {
    Axis.HORIZONTAL: (0.0, 0.0),
    Axis.HEADING: None,
    Axis.VERTICAL: None,
    Axis.ATTITUDE: None,
}


@dataclass(frozen=True, slots=True)
class Unit:
    """The effect of one leg or bare line on the axes: the values that it ``states``, and whether
    it sets the turn to 0 (a heading does)."""

    states: Mapping[Kept, Value]
    drops_turn: bool

    def apply(self, axis: Kept, value: Value) -> Value:
        if axis in self.states:
            return self.states[axis]
        if axis is Axis.HORIZONTAL and self.drops_turn and value is not None:
            return (value[0], 0.0)
        return value


@dataclass(frozen=True, slots=True)
class Flow:
    """A way from a leg or group to a leg; ``unit`` is the joined effect of the bare lines on it."""

    source: str
    target: str
    unit: Unit


def unit_of(node: Leg | Set, outputs: Iterable[str] = ()) -> Unit:
    """The effect of a leg or bare line. ``outputs``: the names of all outputs that the mission
    sets; a surface leg makes them safe."""
    kind = node.kind if isinstance(node, Leg) else None
    unit = _unit(node.settings, kind)
    makes_safe = kind is not None and LEGS[type(kind)].makes_safe(kind)
    safe: dict[Kept, Value] = dict.fromkeys(outputs) if makes_safe else {}
    own: dict[Kept, Value] = {o.name: (o.value,) for o in node.outputs}
    return Unit({**unit.states, **safe, **own}, unit.drops_turn)


def _unit(settings: tuple[Setting, ...], kind: LegKind | None) -> Unit:
    words = {s.word: s.value for s in settings}
    states: dict[Kept, Value] = {}
    if "surge" in words or "turn" in words:
        states[Axis.HORIZONTAL] = (words.get("surge", 0.0), words.get("turn", 0.0))
    if "heading" in words:
        states[Axis.HEADING] = (words["heading"],)
    elif words.get("turn", 0.0) != 0.0:
        states[Axis.HEADING] = None
    held = [word for word in _VERTICAL if word in words]
    if held:
        states[Axis.VERTICAL] = tuple(part for word in held for part in (word, words[word]))
    if "pitch" in words or "roll" in words:
        states[Axis.ATTITUDE] = (words.get("pitch", 0.0), words.get("roll", 0.0))
    steers = LEGS[type(kind)].steers if kind is not None else frozenset()
    states.update(dict.fromkeys(steers, _STEERED))
    if kind is not None and LEGS[type(kind)].ascends:
        states.update(INITIAL)  # an ascent ends with everything stopped
    return Unit(states, "heading" in words or Axis.HEADING in steers)


def own_setpoint(leg: Leg) -> Setpoint:
    """The setpoint of a leg if it were the first one."""
    unit = unit_of(leg)
    return _setpoint({axis: unit.apply(axis, INITIAL[axis]) for axis in Axis})


def joined(units: Iterable[Unit]) -> Unit:
    """The effect of several units, one after the other."""
    states: dict[Kept, Value] = {}
    drops = False
    for unit in units:
        if unit.drops_turn:
            drops = True
            if (held := states.get(Axis.HORIZONTAL)) is not None:
                states[Axis.HORIZONTAL] = (held[0], 0.0)
        states.update(unit.states)
    return Unit(states, drops)


def statement_problems(node: Leg | Set) -> list[Diagnostic]:
    """Report axes that one line states twice, or in contradiction."""
    problems: list[Diagnostic] = []
    seen: dict[str, Setting] = {}
    for setting in node.settings:
        if setting.word in seen:
            problems.append(
                _clash(setting, f"{_word(setting)} is stated twice in this line", "state it once")
            )
        seen[setting.word] = setting
    vertical = [w for w in _VERTICAL if w in seen]
    said_words = [_word(seen[w]) for w in vertical]
    if len(vertical) > 1 and "heave" in vertical:
        problems.append(
            _clash(
                seen[vertical[1]],
                f"{said_words[0]} and {said_words[1]} exclude each other: one axis, one holder",
                f"leave out one of {', '.join(said_words)}",
            )
        )
    if "heading" in seen and "turn" in seen and seen["turn"].value != 0.0:
        problems.append(
            _clash(
                seen["turn"],
                "turn and heading exclude each other",
                "either hold a heading (heading, ZAH) or turn at a rate (left, right, ZAL, ZAR)",
            )
        )
    if isinstance(node, Leg):
        steers = LEGS[type(node.kind)].steers
        own = [s for s in node.settings if _AXIS_OF[s.word] in steers]
        name = LEGS[type(node.kind)].name
        problems += [
            _clash(
                s, f"a {name} leg steers {_AXIS_OF[s.word].value} itself", f"leave out {_word(s)}"
            )
            for s in own
        ]
    return problems


def _clash(setting: Setting, message: str, hint: str) -> Diagnostic:
    return refused("axis-clash", setting.where, message, hint)


class Resolution:
    """The values at every leg. ``parents``: for each leg and group, the group around it."""

    def __init__(
        self,
        legs: Mapping[str, Leg],
        parents: Mapping[str, str],
        flows: Iterable[Flow],
        start: Flow,
        outputs: Iterable[str] = (),
    ) -> None:
        self._legs, self._parents, self._start = legs, parents, start
        self._outputs = tuple(outputs)
        self._kept: tuple[Kept, ...] = (*Axis, *self._outputs)
        self._units = {path: unit_of(leg, self._outputs) for path, leg in legs.items()}
        self._out: dict[str, list[Flow]] = {}
        for flow in flows:
            self._out.setdefault(flow.source, []).append(flow)
        # axis -> leg or group -> the different values that reach it, each with its origin
        self._in: dict[Kept, dict[str, list[tuple[Value, str]]]] = {}
        for axis in self._kept:
            self._in[axis] = {}
            self._spread(axis)

    def setpoints(self) -> tuple[dict[str, Setpoint], list[Diagnostic]]:
        sets, problems = {}, []
        for path, leg in self._legs.items():
            values = {axis: self._value(axis, path) for axis in self._kept}
            problems += self._conflicts(path, leg, values)
            sets[path] = _setpoint(values)
        return sets, problems

    def levels(self) -> dict[str, dict[str, float]]:
        """For each leg: the outputs that are not safe there, with their values."""
        found = {}
        for path in self._legs:
            values = ((name, self._value(name, path)) for name in self._outputs)
            found[path] = {name: float(v[0]) for name, v in values if v is not None}
        return found

    def _value(self, axis: Kept, path: str) -> Value:
        came = self._in[axis].get(path)
        return self._units[path].apply(axis, came[0][0] if came else INITIAL.get(axis))

    def _spread(self, axis: Kept) -> None:
        queue: deque[tuple[str, Value, str]] = deque()
        start = self._start
        queue.append((start.target, start.unit.apply(axis, INITIAL.get(axis)), "the start"))
        for path, unit in self._units.items():
            if axis in unit.states:
                self._leave(queue, axis, path, unit.states[axis], path)
        while queue:
            place, value, origin = queue.popleft()
            held = self._in[axis].setdefault(place, [])
            if any(value == v for v, _ in held) or len(held) == 2:
                continue
            held.append((value, origin))
            here = self._units.get(place)
            if here is None:  # a group passes on the values of all its legs
                self._leave(queue, axis, place, value, origin)
            elif axis not in here.states and len(held) == 1:
                # a second value is the error of this leg only, not of the legs behind it
                self._leave(queue, axis, place, here.apply(axis, value), place)

    def _leave(
        self,
        queue: deque[tuple[str, Value, str]],
        axis: Kept,
        place: str,
        value: Value,
        origin: str,
    ) -> None:
        for flow in self._out.get(place, ()):
            queue.append((flow.target, flow.unit.apply(axis, value), origin))
        if place in self._parents:
            queue.append((self._parents[place], value, origin))

    def _conflicts(self, path: str, leg: Leg, values: dict[Kept, Value]) -> list[Diagnostic]:
        problems = []
        unit = self._units[path]
        for axis in self._kept:
            came = [] if axis in unit.states else self._in[axis].get(path, [])
            if unit.drops_turn and axis is Axis.HORIZONTAL:
                came = list({unit.apply(axis, v): (v, o) for v, o in came}.values())
            if len(came) == 2:
                problems.append(_conflict(axis, leg, came))
            elif came and came[0][0] == _STEERED:
                surge, turn = values[Axis.HORIZONTAL] or (0.0, 0.0)
                if axis is Axis.VERTICAL or (surge != 0.0 and turn == 0.0):
                    assert isinstance(axis, Axis)
                    problems.append(_unknown(axis, leg, came[0][1]))
        return problems


def _conflict(axis: Kept, leg: Leg, came: list[tuple[Value, str]]) -> Diagnostic:
    (one, by_one), (two, by_two) = came
    what = axis.value if isinstance(axis, Axis) else f"output {axis}"
    return refused(
        "axis-conflict",
        leg.where,
        f"{leg.name} omits {what}, and the ways into it bring different values: "
        f"{_words(axis, one)} from {_short(by_one)}, {_words(axis, two)} from {_short(by_two)}",
        f"state {what} in {leg.name}",
    )


def _unknown(axis: Axis, leg: Leg, origin: str) -> Diagnostic:
    return refused(
        "axis-steered",
        leg.where,
        f"{leg.name} omits {axis.value}, which {_short(origin)} steered by itself: "
        "there is no value to keep",
        f"state {axis.value} in {leg.name}",
    )


def _short(path: str) -> str:
    return path.partition("/")[2] or path


def _words(axis: Kept, value: Value) -> str:
    if isinstance(axis, str):
        return "safe" if value is None else f"{float(value[0]):g}"
    if value is None:
        return "none"
    if value == _STEERED:
        return "whatever was steered"
    if axis is Axis.HEADING:
        return f"{math.degrees(float(value[0])) % 360.0:g} deg"
    if axis is Axis.VERTICAL:
        held = [said(word, amount) for word, amount in _held(value).items()]
        return f" {NEVER_BELOW} ".join(held)
    if axis is Axis.HORIZONTAL:
        return f"{said('surge', float(value[0]))} {said('turn', float(value[1]))}"
    return f"pitch {math.degrees(float(value[0])):g} roll {math.degrees(float(value[1])):g}"


def said(field: str, value: float) -> str:
    """A field of the setpoint as a setting of the mission language."""
    if field == "surge":
        return f"gear {value * GEARS:g}"
    low, high = _SIDES.get(field, (field, field))
    amount = abs(value) * GEARS if field in _SIDES else value
    return f"{low if value < 0.0 else high} {amount:g}"


def _held(vertical: tuple[float | str, ...]) -> dict[str, float]:
    """The value of the vertical axis, as fields of the setpoint."""
    return {str(w): float(v) for w, v in zip(vertical[::2], vertical[1::2], strict=True)}


_SIDES = {"turn": ("left", "right"), "heave": ("up", "down")}


def _word(setting: Setting) -> str:
    return said(setting.word, setting.value).partition(" ")[0]


def _setpoint(values: Mapping[Kept, Value]) -> Setpoint:
    def known(axis: Axis) -> Value:
        value = values[axis]
        return None if value == _STEERED else value

    surge, turn = (float(x) for x in known(Axis.HORIZONTAL) or (0.0, 0.0))
    heading, vertical, attitude = known(Axis.HEADING), known(Axis.VERTICAL), known(Axis.ATTITUDE)
    held = _held(vertical or ())
    return Setpoint(
        surge=surge,
        turn=turn,
        heading=float(heading[0]) if heading else None,
        **held,
        pitch=float(attitude[0]) if attitude else None,
        roll=float(attitude[1]) if attitude else None,
    )


def axis_where(leg: Leg, word: str) -> Where:
    """The place where the leg states a word, or else the place of the leg."""
    places = (s.where for s in leg.settings if s.word == word and s.where.line)
    return next(places, leg.where)
