"""Tables that can be extended: a new kind of something is one row in one file.

    LEGS.register(TYPE)                   permanently
    with LEGS.registered(TYPE): ...       until the block ends

Whatever is made from a table (a parser, a list of words) is ``derived``: it is made once, and again
after the table has changed. So no module keeps the state that a table had at import.
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
    """Rows by ``key``, in the order of their registration. ``fault`` returns why a row conflicts
    with the others, or ""."""

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
        """Raises ValueError if the key is registered already, or the row conflicts with others."""
        key = self._key(row)
        if key in self._rows:
            raise ValueError(f"{key} is registered already")
        if fault := self._fault(row, self._rows.values()):
            raise ValueError(fault)
        self._rows[key] = row
        self._tell()

    @contextmanager
    def registered(self, row: R) -> Iterator[R]:
        """Register the row until the block ends."""
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
    """Decorate a function of ``tables``: its result is cached until one of them changes."""

    def decorate(make: Callable[[], T]) -> Callable[[], T]:
        kept = functools.cache(make)
        for table in tables:
            table.when_changed(kept.cache_clear)
        return kept

    return decorate
