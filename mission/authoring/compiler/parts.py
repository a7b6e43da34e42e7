"""Legs that consist of several, as the groups that they are (``LegType.parts``).

Texts, their digest and their differences know the leg as its author wrote it; chart, check, picture
and flight know its parts.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from mission.legs import LEGS
from mission.model import Group, Leg, Node


def parted(body: Iterable[Node]) -> tuple[Node, ...]:
    """The body with a group for each leg that has parts."""
    return tuple(_node(node) for node in body)


def parts_fault(leg: Leg) -> str:
    """What keeps it from being parted; "" where nothing does, or it has no parts."""
    row = LEGS[type(leg.kind)]
    return row.parts_fault(leg) if row.parts(leg) else ""


def _node(node: Node) -> Node:
    if isinstance(node, Group):
        return replace(node, body=parted(node.body))
    if isinstance(node, Leg) and (parts := LEGS[type(node.kind)].parts(node)):
        return Group(node.name, 1, parts, where=node.where, achieve=node.achieve)
    return node
