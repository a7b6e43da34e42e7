"""Turn each leg that consists of several legs into a group of its parts (``LegType.parts``).

Texts, their digest and their differences have the leg as its author wrote it. Chart, check, picture
and flight have its parts.
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
    """Why the leg cannot be divided into its parts; "" if it can, or has no parts."""
    row = LEGS[type(leg.kind)]
    return row.parts_fault(leg) if row.parts(leg) else ""


def _node(node: Node) -> Node:
    if isinstance(node, Group):
        return replace(node, body=parted(node.body))
    if isinstance(node, Leg) and (parts := LEGS[type(node.kind)].parts(node)):
        return Group(node.name, 1, parts, where=node.where, achieve=node.achieve)
    return node
