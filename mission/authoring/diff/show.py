"""Show a difference as text for a terminal, as Markdown for a review, and as an object.

What does not live here: finding the differences (changes.py, difference.py).
"""

from __future__ import annotations

from typing import Any

from mission.authoring.check import Report
from mission.authoring.diff.changes import Change, Kind
from mission.authoring.diff.difference import Difference, Figure
from mission.authoring.prepare import Prepared

SAME = "no difference for the vehicle"


def as_object(found: Difference) -> dict[str, Any]:
    return {
        "same": found.same,
        "before": _side(found.before, found.reports[0]),
        "after": _side(found.after, found.reports[1]),
        "changes": [_change(row) for row in found.changes],
        "renamed": [{"before": a, "after": b} for a, b in found.renamed],
        "worst": {f.key: {"before": f.before, "after": f.after} for f in found.figures},
    }


def _side(prepared: Prepared, report: Report) -> dict[str, Any]:
    return {
        "file": prepared.source,
        "mission": prepared.mission.name,
        "vehicle": prepared.vehicle.name,
        "digest": prepared.chart.digest,
        "ok": report.ok,
        "refusals": [r.as_object() for r in report.refusals],
    }


def _change(row: Change) -> dict[str, Any]:
    return {
        "kind": row.kind.value,
        "places": list(row.places),
        "what": row.what,
        "before": row.before,
        "after": row.after,
        "lines": [{"before": a or None, "after": b or None} for a, b in row.lines],
    }


# --- text --------------------------------------------------------------------------------------


def as_text(found: Difference) -> str:
    rows = [f"{found.before.source} -> {found.after.source}"]
    if found.same:
        rows.append(SAME)
        rows += [f"  only another name: {a} -> {b}" for a, b in found.renamed]
        return "\n".join(rows)
    rows += ["", "changed for the vehicle"]
    for change in found.changes:
        rows.append(f"  {change.kind.value:8} {', '.join(change.places)}: {_told(change)}")
    if found.renamed:
        rows += ["", "names", *(f"  {a} -> {b}" for a, b in found.renamed)]
    rows += ["", f"{'worst case':13}{'before':>12}{'after':>12}{'change':>12}"]
    for figure in found.figures:
        cells = "".join(f"{cell:>12}" for cell in _cells(figure))
        rows.append(f"  {figure.name:11}{cells}")
    for word, report in zip(("before", "after"), found.reports, strict=True):
        rows += ["", *_verdict(word, report)]
    return "\n".join(rows)


def _told(change: Change) -> str:
    match change.kind:
        case Kind.ADDED:
            return f"{_what(change)}{change.after}"
        case Kind.REMOVED:
            return f"{_what(change)}{change.before}"
        case _:
            return f"{_what(change)}{change.before}  =>  {change.after}"


def _what(change: Change) -> str:
    """The label of a change; empty if its values are clear without one."""
    plain = change.what in ("leg", "heading", "speed", "vertical", "attitude", "does", "place")
    return "" if plain else f"{change.what} "


def _cells(figure: Figure) -> tuple[str, str, str]:
    change = figure.change
    return (
        _amount(figure.before, figure.unit),
        _amount(figure.after, figure.unit),
        "" if change is None else "-" if abs(change) < 0.05 else _amount(change, figure.unit, "+"),
    )


def _amount(value: float | None, unit: str, sign: str = "") -> str:
    if value is None:
        return "none"
    if unit == "s":
        return f"{value / 60:{sign}.1f} min"
    return f"{value:{sign}.1f} {unit}" if unit == "m" else f"{value:{sign}.0f} {unit}"


def _verdict(word: str, report: Report) -> list[str]:
    if report.ok:
        return [f"{word}: the check passes it"]
    lines = [f"  line {r.where.line}: {r.message} [{r.code}]" for r in report.refusals]
    return [f"{word}: the check refuses it", *lines]


# --- Markdown ----------------------------------------------------------------------------------


def as_markdown(found: Difference) -> str:
    before, after = found.before, found.after
    rows = [f"### {_cell(after.mission.name)}: what changes for the vehicle", ""]
    rows += [f"`{before.source}` \u2192 `{after.source}`, vehicle {after.vehicle.name}", ""]
    if found.same:
        rows += [f"**{SAME[0].upper()}{SAME[1:]}.**", *_names(found)]
        return "\n".join(rows).rstrip()
    rows += [_checked(found), ""]
    rows += ["| | where | what | before | after | line |", "|---|---|---|---|---|---|"]
    rows += [_row(change) for change in found.changes]
    rows += [*_names(found), "", "| worst case | before | after | change |", "|---|---:|---:|---:|"]
    for figure in found.figures:
        rows.append(f"| {figure.name} | {' | '.join(_cells(figure))} |")
    for word, report in zip(("before", "after"), found.reports, strict=True):
        for refusal in report.refusals:
            place = f"{word}, line {refusal.where.line}"
            rows += ["", f"- {place}: {_cell(refusal.message)} (`{refusal.code}`)"]
    return "\n".join(rows)


def _checked(found: Difference) -> str:
    was, now = (report.ok for report in found.reports)
    if now:
        return "The check passes it." if was else "The check passes it now."
    return "**The check refuses it" + (", as before.**" if not was else "; it passed before.**")


def _row(change: Change) -> str:
    lines = [str(b) if b else f"({a})" for a, b in change.lines if a or b]
    cells = (
        change.kind.value,
        ", ".join(f"`{place}`" for place in change.places),
        change.what,
        _cell(change.before),
        _cell(change.after),
        ", ".join(lines),
    )
    return f"| {' | '.join(cells)} |"


def _names(found: Difference) -> list[str]:
    told = [f"`{a}` \u2192 `{b}`" for a, b in found.renamed]
    return ["", f"Other names: {', '.join(told)}"] if told else []


def _cell(text: str) -> str:
    """The text with escapes, so that a table's cell does not read as Markdown or HTML."""
    for sign in "\\|<>*_`":
        text = text.replace(sign, f"\\{sign}")
    return text
