"""Tables of the reference that stand in the code as tables already, as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from from_code.commands import escaped
from links import LINKS
from links.simulated.faults import FAULTS
from links.simulated.settings import SETTINGS
from mission.engine.limits import LIMITS, Limit
from mission.model.alarms import ALARMS
from mission.model.codes import CODES
from mission.model.units import number_text
from mission.model.vehicle_ranges import RANGES, TOGETHER, Range
from mission.onboard.stream.schemas import Schema
from mission.onboard.stream.topics import TOPICS, Topic


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def vehicle_ranges() -> str:
    """Every number of a vehicle file: key, unit of a bare number, smallest and greatest value."""
    rows = [(f"`{key}`", row.unit or "number", _bounds(row)) for key, row in RANGES.items()]
    return _table(("key", "bare number", "range"), rows)


def _bounds(row: Range) -> str:
    first = "more than " if row.above else ""
    return f"{first}{number_text(row.low)} to {number_text(row.high)}"


def diagnostic_codes() -> str:
    return _table(("code", "says"), [(f"`{code}`", escaped(says)) for code, says in CODES.items()])


def vehicle_pairs() -> str:
    rows = [
        (f"`{p.less}`", "at most" if p.equal else "below", f"`{p.more}`", escaped(p.why))
        for p in TOGETHER
    ]
    return _table(("this", "must be", "this", "else"), rows)


def alarms() -> str:
    """Every alarm with its level and what to do."""
    rows = [(row.name, row.level, escaped(row.do)) for row in ALARMS.values()]
    return _table(("alarm", "level", "what to do"), rows)


def limits() -> str:
    """Every limit: from what it is seen, beyond what, for how long, where it acts, what follows."""
    rows = [
        (
            *(row.name, escaped(row.source), escaped(row.bound), _lasts(row)),
            *(", ".join(sorted(row.acts)), row.response.value),
        )
        for row in LIMITS.values()
    ]
    return _table(("limit", "seen from", "bound", "lasts", "acts in", "then"), rows)


def _lasts(row: Limit) -> str:
    if row.seconds:
        return f"{row.seconds:g} s"
    return "at once" if row.samples == 1 else f"{row.samples} samples"


def link_schemes() -> str:
    rows = [
        (f"`{name}`", f"`{row.example}`", ", ".join(f"`{o}`" for o in row.options))
        for name, row in LINKS.items()
    ]
    return _table(("scheme", "example", "options"), rows)


def topic_tables() -> str:
    """Every topic of a black box, with its fields."""
    return "\n\n".join(map(_topic, TOPICS.values()))


def _topic(topic: Topic) -> str:
    known = f", schema `{topic.well_known}`" if topic.well_known else ""
    rows = [
        (f"`{name}`", _kind_of(field), escaped(field.get("description", "")))
        for name, field in topic.schema["properties"].items()
    ]
    head = f"### {topic.name}\n\n{escaped(topic.says)} ({topic.role}{known})."
    return f"{head}\n\n{_table(('field', 'is', 'unit, meaning'), rows)}"


def _kind_of(schema: Schema) -> str:
    if "anyOf" in schema:
        return f"{_kind_of(schema['anyOf'][0])} or null"
    kind = schema.get("type", "anything")
    return kind if isinstance(kind, str) else " or ".join(kind)


def simulation_settings() -> str:
    """What ``--set`` takes, and the faults it can begin."""
    settings = [(f"`{k}={row.form}`", escaped(row.says)) for k, row in SETTINGS.items()]
    faults = ", ".join(f"`{name}`" for name in FAULTS)
    return f"{_table(('setting', 'what'), settings)}\n\nThe faults: {faults}."
