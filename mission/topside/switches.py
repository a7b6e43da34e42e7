"""The Pi's nodes and the power of the vehicle's devices, switched by name. Sans-IO.

    names --> @NI or @RI: how is it now? --> the six or seven letters of @NS or @RS

@RI may report other bits than the document's (a radio at bit 6). So the letters that were sent are
reported, and devices that are always on are never switched off: the radio may be the way in.

BDGPS and UACM are both a node and a power switch. A node must be closed before its power is
switched off, and the power must be on before the node is opened (R14).
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence

from mission.topside.upload import Ask, NoAnswer, Refused, Script
from mission.topside.words import Took, asked_mask, say
from protocol.messages import NodeQuery, NodeSwitch, Relay
from protocol.topside import Answer
from protocol.topside_frames import ALWAYS_ON, NODES, RI, RS, SENSORS

BOTH = frozenset(NODES) & frozenset(SENSORS)
_POWER_QUERY = Relay("RI", RI.encode({}))


def nodes(changes: Mapping[str, bool], took: Took = lambda values: None) -> Script:
    """``changes``: nodes by name, True to open; if empty, report their states."""
    if not changes:
        return (yield from say(NodeQuery(), took))
    if opened := [name for name in BOTH if changes.get(name)]:
        powered = yield from _powered()
        for name in opened:
            if powered is not None and not powered >> SENSORS.index(name) & 1:
                raise Refused(f"{name} has no power: auvmission power {name}=on, then its node")
    mask = yield from asked_mask(NodeQuery(), "NI")
    letters = _letters(NODES, mask, changes)
    done = yield from say(NodeSwitch(letters))
    return f"{done}, {letters} sent: {_named(NODES, letters)}"


def power(changes: Mapping[str, bool], took: Took = lambda values: None) -> Script:
    """``changes``: devices by name, True to switch on; if empty, report their states."""
    if not changes:
        return (yield from say(_POWER_QUERY, took))
    if shut := [name for name in BOTH if changes.get(name) is False]:
        opened = yield from asked_mask(NodeQuery(), "NI")
        for name in shut:
            if opened >> NODES.index(name) & 1:
                raise Refused(f"its node is open: auvmission nodes {name}=closed, then its power")
    mask = yield from asked_mask(_POWER_QUERY, "RI")
    always = {SENSORS[bit]: True for bit in ALWAYS_ON}
    letters = _letters(SENSORS, mask, {**changes, **always})
    done = yield from say(Relay("RS", RS.encode({"switches": letters})))
    return f"{done}, {letters} sent: {_named(SENSORS, letters)}"


def _powered() -> Generator[Ask, Answer | None, int | None]:
    """Return the mask of powered devices; None if the vehicle switches no power."""
    try:
        mask: int = yield from asked_mask(_POWER_QUERY, "RI")
    except (NoAnswer, Refused):
        return None
    return mask


def _letters(names: Sequence[str], mask: int, changes: Mapping[str, bool]) -> str:
    return "".join(
        "O" if changes.get(name, bool(mask >> bit & 1)) else "C" for bit, name in enumerate(names)
    )


def _named(names: Sequence[str], letters: str) -> str:
    """Name what is open or on now."""
    opened = [name for name, letter in zip(names, letters, strict=True) if letter == "O"]
    return f"{', '.join(opened) or 'none'} and no other"
