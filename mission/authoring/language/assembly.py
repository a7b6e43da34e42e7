"""Build one Mission from the statements of a text: headers, groups, names, targets, loops.

Both readers (lines.py, yaml_form.py) deliver the same kinds of statements. Rules:

    parameters are read first, then the vehicle, then everything else; a name is looked up in the
    innermost group first, then outwards; a repeated group must contain something that takes time.

What does not live here: grammar (syntax.py), parameters (parameters.py), clauses (legs.py),
reachability (mission.authoring.check).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from mission.authoring.language import elsewhere
from mission.authoring.language.clauses import (
    AreaText,
    End,
    HomeAt,
    LegText,
    MissionHead,
    Name,
    Named,
    On,
    Opening,
    Parameter,
    Statement,
    WithoutFix,
)
from mission.authoring.language.files import Files, no_files
from mission.authoring.language.legs import Legs
from mission.authoring.language.parameters import read_parameters
from mission.authoring.language.values import Values
from mission.authoring.language.words import AIMS, ASSUMPTIONS, GENERATED, LIMITS
from mission.model import (
    NOWHERE,
    SURFACE,
    Aims,
    Area,
    Group,
    Handler,
    Mission,
    Node,
    Position,
    Safety,
    Where,
    legs_of,
)
from mission.model.diagnostics import Diagnostics
from mission.model.extent import AREAS, DEEPEST_GROUP, HANDLERS, NAME
from mission.model.likeness import nearest, suggestion
from mission.model.shipped import missions_folder
from mission.model.vehicle import Vehicle

UNNAMED = "unnamed"
DEFAULT_VEHICLE = "auv"
MOST_ROUNDS = 9999
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(?:-[A-Za-z0-9_]+)*\Z")


@dataclass(slots=True)
class _Scope:
    """A group that is still open; the outermost scope is the mission itself."""

    opening: Opening | None
    repeat: int = 1
    body: list[Node] = field(default_factory=list)
    handlers: list[Handler] = field(default_factory=list)
    names: dict[str, Where] = field(default_factory=dict)
    achieve: Aims = ()


@dataclass(frozen=True, slots=True)
class _Target:
    name: str
    where: Where
    scopes: tuple[_Scope, ...]  # outermost first


@dataclass(slots=True)
class _Head:
    name: str = UNNAMED
    vehicle: str = DEFAULT_VEHICLE
    total: Name | None = None
    home: Position | None = None
    safety: Safety = field(default_factory=Safety)
    assume: tuple[tuple[str, float], ...] = ()
    on_uncertain: str = SURFACE
    on_timeout: str = SURFACE
    without_fix: bool = False
    areas: list[Area] = field(default_factory=list)
    where: Where = NOWHERE


class Assembly:
    """Builds the mission of one file. The result is complete only if no problem was found."""

    def __init__(
        self,
        problems: Diagnostics,
        parameters: Mapping[str, str],
        vehicle: Vehicle | None = None,
        files: Files = no_files,
    ) -> None:
        """``vehicle``: the vehicle that is to fly the mission, ``flown`` of Values."""
        self._files = files
        self._problems = problems
        self._given, self._flown = parameters, vehicle
        self._head = _Head()
        self._seen: dict[str, Where] = {}
        self._scopes = [_Scope(None)]
        self._targets: list[_Target] = []
        self._handlers = 0

    def read(self, statements: Sequence[Statement]) -> tuple[Mission, Name | None]:
        """The mission, and the ``sum`` that its first line states."""
        parameters = read_parameters(statements, self._given, self._problems)
        named = self._vehicle(statements)
        self._values = Values(self._problems, parameters, named, self._flown)
        areas = {s.name.text: s for s in statements if isinstance(s, AreaText)}
        self._legs = Legs(self._values, areas, self._files)
        for index, statement in enumerate(statements):
            self._take(statement, first=index == 0)
        while len(self._scopes) > 1:
            self._unclosed()
        self._resolve()
        top = self._scopes[0]
        if not len(self._problems) and not any(legs_of(top.body)):
            where = statements[0].where if statements else Where(1, 1)
            hint = "add for instance a line  wait 30s"
            self._problems.add("empty-mission", where, "nothing in this mission takes time", hint)
        return self._mission(top), self._head.total

    def _mission(self, top: _Scope) -> Mission:
        head = self._head
        return Mission(
            name=head.name,
            vehicle=head.vehicle,
            body=tuple(top.body),
            home=head.home,
            safety=head.safety,
            assume=head.assume,
            handlers=tuple(top.handlers),
            on_uncertain=head.on_uncertain,
            on_timeout=head.on_timeout,
            start_without_fix=head.without_fix,
            where=head.where,
            achieve=top.achieve,
            areas=tuple(sorted(head.areas, key=lambda area: (area.out, area.name))),
        )

    # --- first: the vehicle, which the other statements need ---------------------------------

    def _vehicle(self, statements: Iterable[Statement]) -> str:
        """The name of the mission's vehicle; its file is read later, and only if needed."""
        named = next((s for s in statements if isinstance(s, MissionHead)), None)
        name = named.vehicle if named else None
        wanted = name.text if name else DEFAULT_VEHICLE
        known = sorted(path.stem for path in (missions_folder() / "vehicles").glob("*.yaml"))
        if wanted not in known:
            where = name.where if name else NOWHERE
            hint = suggestion(wanted, known, "vehicles")
            self._problems.add("unknown-vehicle", where, f"unknown vehicle {wanted!r}", hint)
        return wanted

    # --- then: each statement in turn ----------------------------------------------------------

    def _take(self, statement: Statement, first: bool) -> None:
        match statement:
            case MissionHead():
                self._mission_head(statement, first)
            case HomeAt(place, where):
                if self._header("home", where):
                    self._head.home = self._values.position(place)
            case Named("safety", _, where):
                if self._header("safety", where):
                    self._head.safety = Safety(**dict(self._values.named(statement, LIMITS)))
            case Named(_, _, where):
                if self._header("assume", where):
                    assumed = self._values.named(statement, ASSUMPTIONS)
                    self._head.assume = tuple(sorted(assumed))
            case AreaText() | Parameter() | WithoutFix():
                self._say(statement)
            case Opening():
                self._open(statement)
            case End(where):
                self._close(where)
            case On():
                self._on(statement)
            case LegText():
                self._leg(statement)

    def _say(self, header: AreaText | Parameter | WithoutFix) -> None:
        match header:
            case AreaText():
                self._area(header)
            case Parameter():
                self._top("param", header.where)
            case WithoutFix():
                if self._header("start", header.where):
                    self._head.without_fix = True

    def _mission_head(self, head: MissionHead, first: bool) -> None:
        if not self._header("mission", head.where):
            return
        if not first:
            hint = "move it to the first line"
            self._problems.add("not-first", head.where, "mission stands first", hint)
        self._check_name(head.name)
        self._head.name = head.name.text
        self._head.vehicle = head.vehicle.text if head.vehicle else DEFAULT_VEHICLE
        self._head.total, self._head.where = head.total, head.where

    def _area(self, text: AreaText) -> None:
        areas = self._head.areas
        if not self._top("keep", text.where):
            return
        self._check_name(text.name)
        if text.name.text in (area.name for area in areas):
            message, hint = f"area {text.name.text} appears twice", "give it another name"
            self._problems.add("duplicate-name", text.name.where, message, hint)
        areas.append(self._values.area(text))
        if len(areas) == AREAS.most + 1:
            self._problems.add("too-long", text.where, AREAS.exceeded, "join some of them")

    def _top(self, word: str, where: Where) -> bool:
        if len(self._scopes) > 1:
            message = f"{word} does not belong into a group"
            self._problems.add("inside-group", where, message, "move it to the top")
        return len(self._scopes) == 1

    def _header(self, word: str, where: Where) -> bool:
        if not self._top(word, where):
            return False
        if word in self._seen:
            message = f"{word} appears twice; the first is in line {self._seen[word].line}"
            self._problems.add("twice", where, message, "keep one of them")
            return False
        self._seen[word] = where
        return True

    def _open(self, opening: Opening) -> None:
        if len(self._scopes) > DEEPEST_GROUP.most:
            message = f"groups are nested too deep: {DEEPEST_GROUP.exceeded}"
            raise self._problems.refusal("too-deep", opening.where, message, "flatten them")
        self._declare(opening.name)
        repeat = 1
        if opening.repeat is not None:
            repeat = self._values.whole(opening.repeat, 1, MOST_ROUNDS, "repeat")
        self._scopes.append(_Scope(opening, repeat))

    def _close(self, where: Where) -> None:
        if len(self._scopes) == 1:
            hint = "remove it, or write repeat or group before"
            self._problems.add("end", where, "end closes nothing", hint)
            return
        scope = self._scopes.pop()
        opening = scope.opening
        assert opening is not None
        if not self._problems.within(opening.where.line, where.line):
            self._check_body(scope, opening.name)
        group = Group(
            opening.name.text,
            scope.repeat,
            tuple(scope.body),
            tuple(scope.handlers),
            opening.where,
            scope.achieve,
        )
        self._scopes[-1].body.append(group)

    def _check_body(self, scope: _Scope, name: Name) -> None:
        if not scope.body:
            self._problems.add(
                "empty-group", name.where, f"group {name.text} is empty", "add a leg"
            )
        elif scope.repeat > 1 and not any(legs_of(scope.body)):
            hint = "add a wait: bare ZA lines set and go on at once"
            message = f"loop {name.text} takes no time"
            self._problems.add("loop-without-wait", name.where, message, hint)

    def _unclosed(self) -> None:
        opening = self._scopes[-1].opening
        assert opening is not None
        message = f"group {opening.name.text} is not closed"
        self._problems.add("unclosed", opening.where, message, "write end after its last line")
        self._close(opening.where)

    def _on(self, on: On) -> None:
        self._target(on.target)
        if not isinstance(on.when, str):
            guard = self._values.guard(on.when)
            self._scopes[-1].handlers.append(Handler(guard, on.target.text, on.where))
            self._handlers += 1
            if self._handlers > HANDLERS.most:
                raise self._problems.refusal(
                    "too-long", on.where, HANDLERS.exceeded, "join their guards"
                )
        elif self._header(f"on {on.when}", on.where):
            if on.when == "uncertain":
                self._head.on_uncertain = on.target.text
            else:
                self._head.on_timeout = on.target.text

    def _achieve(self, aims: Named) -> None:
        scope = self._scopes[-1]
        if scope.achieve:
            self._problems.add("twice", aims.where, "achieve appears twice", "keep one of them")
        scope.achieve = tuple(sorted(self._values.named(aims, AIMS)))

    def _leg(self, text: LegText) -> None:
        match text:
            case LegText(None, (Named() as aims,)):
                self._achieve(aims)
                return
        if text.name is not None:
            self._declare(text.name)
        node = self._legs.build(text)
        self._scopes[-1].body.append(node)
        for clause in text.clauses:
            target = getattr(clause, "target", None)
            if isinstance(target, Name):
                self._target(target)

    # --- names -----------------------------------------------------------------------------------

    def _check_name(self, name: Name) -> None:
        if not _NAME.match(name.text):
            hint = "a letter, then letters, digits, _ and -"
            self._problems.add("label", name.where, f"{name.text!r} is no name", hint)
        elif len(name.text) > NAME.most:
            hint = f"at most {NAME.most} characters"
            self._problems.add("long-name", name.where, "this name is too long", hint)

    def _declare(self, name: Name) -> None:
        self._check_name(name)
        names = self._scopes[-1].names
        if name.text == SURFACE:
            hint = "call it for instance up"
            message = "surface is the name of the leg that ends every mission"
            self._problems.add("reserved-name", name.where, message, hint)
        elif name.text in elsewhere.CONTROL:
            hint = f"call it for instance {name.text}_1"
            message = elsewhere.no_name(name.text)
            self._problems.add("control-word", name.where, message, hint)
        elif GENERATED.match(name.text):
            hint = f"call it for instance {name.text.replace('line', 'leg')}"
            message = f"{name.text} is what a leg without a name is called"
            self._problems.add("reserved-name", name.where, message, hint)
        elif name.text in names:
            message = f"{name.text} appears twice; the first is in line {names[name.text].line}"
            hint = f"call this one for instance {name.text}_2"
            self._problems.add("duplicate-name", name.where, message, hint)
        names.setdefault(name.text, name.where)

    def _target(self, name: Name) -> None:
        self._targets.append(_Target(name.text, name.where, tuple(self._scopes)))

    def _resolve(self) -> None:
        """Look up all targets. This happens last, since a target may name a later leg."""
        top = (self._scopes[0],)
        for target in self._targets:
            if target.name == SURFACE or any(target.name in s.names for s in target.scopes):
                continue
            visible = [SURFACE, *(name for s in reversed(target.scopes) for name in s.names)]
            close = nearest(target.name, visible)
            hint = f"did you mean {close}?" if close else "names: " + ", ".join(visible[:20])
            if GENERATED.match(target.name):
                hint = "give that line a name to go there"
            elif target.scopes != top:
                hint += " (a leg inside another group cannot be a target)"
            self._problems.add(
                "unknown-target", target.where, f"there is no leg {target.name!r} here", hint
            )
