"""A copy of state shares nothing that can change, and cannot forget an attribute."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Self

import pytest

from mission.model.copies import copied


@dataclass(frozen=True)
class Frozen:
    value: int


class Slotted:
    __slots__ = ("absent", "seen")

    def __init__(self) -> None:
        self.seen = [1]

    def clone(self) -> Self:
        return copied(self, absent=None)


class State:
    def __init__(self) -> None:
        self.frozen, self.number, self.text, self.nothing = Frozen(1), 1.0, "a", None
        self.table, self.names, self.line = {"a": 1}, {"a"}, deque([1], maxlen=2)
        self.part = Slotted()
        self.function = len

    def clone(self) -> Self:
        return copied(self)


def test_a_copy_shares_nothing_that_can_change() -> None:
    one = State()
    other = one.clone()
    assert vars(other).keys() == vars(one).keys()
    for name in ("table", "names", "line", "part"):
        assert getattr(other, name) is not getattr(one, name), name
    assert (other.table, other.names, other.line) == (one.table, one.names, one.line)
    assert other.line.maxlen == 2
    assert other.part.seen == one.part.seen
    assert other.part.seen is not one.part.seen
    assert other.frozen is one.frozen


def test_an_attribute_that_came_later_is_copied_too() -> None:
    one = State()
    one.clone()
    one.late = {1: 2}  # type: ignore[attr-defined]
    assert one.clone().late == {1: 2}  # type: ignore[attr-defined]
    assert one.clone().late is not one.late  # type: ignore[attr-defined]


def test_what_can_change_and_says_not_how_it_is_copied_is_refused() -> None:
    class Unknown:
        pass

    one = State()
    one.part = Unknown()  # type: ignore[assignment]
    with pytest.raises(TypeError, match="Unknown"):
        one.clone()
