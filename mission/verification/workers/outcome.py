"""The outcome of a job: its result, or the reason why there is none."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

RETRIES = 1  # of a job whose worker was lost
_J = TypeVar("_J")
_R = TypeVar("_R")


class Unreachable(RuntimeError):
    """No scheduler, no worker, no keys, or workers that cannot be used."""


@dataclass(frozen=True, slots=True)
class Lost:
    """A job without a result. ``error`` is what it raised; None: its workers were lost."""

    name: str
    why: str
    error: Exception | None = None

    def __str__(self) -> str:
        return f"{self.name}: no result: {self.why}"


@dataclass(frozen=True, slots=True)
class Raised:
    """What a job raised, or what prevents its result from being sent or read."""

    error: Exception

    def lost(self, name: str) -> Lost:
        return Lost(name, f"raised {type(self.error).__name__}: {self.error}", self.error)


Run = Callable[[Iterable[tuple[str, _J]]], Iterator[tuple[str, _R | Lost]]]
"""Jobs with their names in, as many as are wanted at a time; outcomes out, in any order."""


def had(outcome: _R | Lost) -> _R:
    """Return the result, for a caller that needs it. If there is none, raises what the job raised,
    else RuntimeError."""
    if isinstance(outcome, Lost):
        raise outcome.error or RuntimeError(str(outcome))
    return outcome


def tried(work: Callable[[_J], Any], job: _J) -> Any:
    """Do a job; return its result, or Raised. MemoryError passes: its cause is the worker."""
    try:
        return work(job)
    except MemoryError:
        raise
    except Exception as error:  # a job that fails does not end the others
        return Raised(_portable(error))


def answer(work: Callable[[_J], Any], job: _J) -> bytes:
    """Do a job in another process than the caller's: return its result or Raised, for ``read``."""
    found = tried(work, job)
    try:
        return pickle.dumps(found)
    except MemoryError:
        raise
    except Exception as error:
        return pickle.dumps(Raised(ValueError(f"the result cannot be sent: {error}")))


def read(name: str, answered: bytes) -> Any | Lost:
    """Return what ``answer`` has found for the job of this name. Reading it runs code of the
    result's own, which may fail in this process alone."""
    try:
        found = pickle.loads(answered)
    except Exception as error:
        words = f"the result cannot be read: {type(error).__name__}: {error}"
        return Raised(ValueError(words)).lost(name)
    return found.lost(name) if isinstance(found, Raised) else found


def _portable(error: Exception) -> Exception:
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # pickle does not know the arguments of some
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
