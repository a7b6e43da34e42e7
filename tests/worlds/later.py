"""Libraries that one file of the tests uses, imported by the worker that runs it.

Every worker collects every file. What a file imports at its top, each worker imports: pandas,
matplotlib, scipy.stats and a few others were a third of all that collection took.
"""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any

import pytest


class Later:
    """A module that is imported when something in it is first asked for; so not by pytest, which
    asks everything in a file of tests for names that begin with an underscore."""

    def __init__(self, module: str) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(importlib.import_module(self._module), name)


def installed(module: str, reason: str) -> Later:
    """``pytest.importorskip`` for a whole file, which imports nothing yet."""
    if importlib.util.find_spec(module.partition(".")[0]) is None:
        pytest.skip(reason, allow_module_level=True)
    return Later(module)
