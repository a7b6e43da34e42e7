"""Tables of rows that are made to be added to: a new kind of something is one row in one file.

    LEGS.register(TYPE)                   for good
    with LEGS.registered(TYPE): ...       for a while

Whatever is made of a table (a parser, a list of words) is ``derived``: made once, and anew when the
table has changed. So no module keeps what a table said when it was imported.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Generic, TypeVar

K = TypeVar("K")
R = TypeVar("R")
T = TypeVar("T")


class Table(Mapping[K, R], Generic[K, R]):
    """Rows by ``key``, in the order in which they were registered. ``fault`` says why a row does
    not go with the others, or ""."""

    def __init__(
        self,
        key: Callable[[R], K],
        rows: Iterable[R],
        fault: Callable[[R, Iterable[R]], str] = lambda row, others: "",
    ) -> None:
        self._key, self._fault = key, fault
        self._rows = {key(row): row for row in rows}
        self._changed: list[Callable[[], None]] = []

    def __getitem__(self, key: K) -> R:
        return self._rows[key]

    def __iter__(self) -> Iterator[K]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    def register(self, row: R) -> None:
        """Raises ValueError if there is such a row already, or one that it contradicts."""
        key = self._key(row)
        if key in self._rows:
            raise ValueError(f"{key} is registered already")
        if fault := self._fault(row, self._rows.values()):
            raise ValueError(fault)
        self._rows[key] = row
        self._tell()

    @contextmanager
    def registered(self, row: R) -> Iterator[R]:
        """The row is there until the block is left."""
        self.register(row)
        try:
            yield row
        finally:
            del self._rows[self._key(row)]
            self._tell()

    def when_changed(self, forget: Callable[[], None]) -> None:
        self._changed.append(forget)

    def _tell(self) -> None:
        for forget in self._changed:
            forget()


def derived(*tables: Table[Any, Any]) -> Callable[[Callable[[], T]], Callable[[], T]]:
    """Decorates a function of ``tables``: its result is kept until one of them has changed."""

    def decorate(make: Callable[[], T]) -> Callable[[], T]:
        kept = functools.cache(make)
        for table in tables:
            table.when_changed(kept.cache_clear)
        return kept

    return decorate
