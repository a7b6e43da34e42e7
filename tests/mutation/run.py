"""Mutation testing of one module: change one thing at a time, and see whether its tests notice.

    python tests/mutation/run.py mission/engine/machine.py tests/engine/test_machine.py ... [--seconds N]
    python tests/mutation/run.py mission/engine/machine.py tests/engine/test_machine.py ... --only 3,17
    python tests/mutation/run.py ... --on processes|dask://HOST:PORT [--workers N] [--resume FILE]

The tests are collected once; each mutant is a fork of that process in which the functions get the
bodies of the mutated tree, so no file is ever changed. What stands outside of functions, or within
one that another made, is changed in a fork that has not imported the module yet; so is everything
with ``--fresh``. Prints a line per survivor with its number, and the score; ``--only`` tries those
numbers again, with other tests or after new ones. Examples are the same ones in every run.

What is mutated: comparisons, boolean and arithmetic operators, ``not``, numbers, True and False,
returned values, and calls that stand alone.
"""

from __future__ import annotations

import argparse
import ast
import copy
import importlib.abc
import importlib.machinery
import importlib.util
import itertools
import math
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

import pytest
from _pytest.runner import runtestprotocol
from hypothesis import settings

LIMIT_S = 120  # of one mutant's tests: beyond, it hangs, which was noticed
PATIENCE_S = 3600.0  # of a part of the mutants, on another worker
_HEAVY = (*("hypothesis.stateful", "numpy", "transitions.extensions", "lark", "yaml"),)
_OPTIONS = (
    "-x",
    "-q",
    *("-p", "no:cacheprovider", "-p", "no:cov"),
    *("-W", "ignore:Module already imported:pytest.PytestAssertRewriteWarning"),
)
_COMPARISONS = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
    ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_ARITHMETIC = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Add, ast.FloorDiv: ast.Mult,
    ast.Div: ast.Mult, ast.Mod: ast.Add, ast.BitXor: ast.BitOr, ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd, ast.LShift: ast.RShift, ast.RShift: ast.LShift,
}  # fmt: skip


def variants(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """What a node can be changed into, in words and as a tree."""
    if isinstance(node, ast.Compare):
        for i, operator in enumerate(node.ops):
            other = copy.deepcopy(node)
            other.ops[i] = _COMPARISONS[type(operator)]()
            yield ast.unparse(other), other
    elif isinstance(node, ast.BoolOp):
        other = copy.deepcopy(node)
        other.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield ast.unparse(other), other
    elif isinstance(node, ast.BinOp | ast.AugAssign) and type(node.op) in _ARITHMETIC:
        other = copy.deepcopy(node)
        other.op = _ARITHMETIC[type(node.op)]()
        yield ast.unparse(other), other
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield ast.unparse(node.operand), node.operand
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield str(not node.value), ast.Constant(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        yield str(node.value + 1), ast.Constant(node.value + 1)
    elif isinstance(node, ast.Return) and node.value is not None:
        if not (isinstance(node.value, ast.Constant) and node.value.value is None):
            yield "return None", ast.Return(ast.Constant(None))
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        yield "pass", ast.Pass()


def _strip(node: ast.AST) -> None:
    """Annotations are not evaluated, and decorators' flags decide nothing that a test may see."""
    if isinstance(node, ast.FunctionDef):
        node.returns = None
        every = (*node.args.args, *node.args.kwonlyargs, node.args.vararg, node.args.kwarg)
        for argument in every:
            if argument is not None:
                argument.annotation = None
    elif isinstance(node, ast.AnnAssign):
        node.annotation = ast.Constant(None)
    elif isinstance(node, ast.ClassDef):
        for decorator in node.decorator_list:
            if isinstance(decorator, ast.Call):
                decorator.keywords = [k for k in decorator.keywords if k.arg is None] + [
                    _Kept(arg=k.arg, value=k.value) for k in decorator.keywords if k.arg
                ]


class _Kept(ast.keyword):
    """Not to be looked into."""


class _Put(ast.NodeTransformer):
    """Puts the n-th variant into the tree."""

    def __init__(self, wanted: int) -> None:
        self.wanted, self.seen = wanted, 0
        self.words, self.line = "", 0

    def visit(self, node: ast.AST) -> ast.AST:
        _strip(node)
        if isinstance(node, _Kept):
            return node
        for words, other in variants(node):
            if self.seen == self.wanted:
                self.line = node.lineno  # type: ignore[attr-defined]
                self.words = f"line {self.line}: {ast.unparse(node)}  ->  {words}"
                self.seen += 1
                return ast.copy_location(other, node)
            self.seen += 1
        return super().generic_visit(node)


@dataclass(frozen=True, slots=True)
class Mutant:
    number: int
    words: str
    tree: ast.Module
    inside: bool  # a function's body, and of none within it: changed in place where imported


def mutants(source: str) -> Iterator[Mutant]:
    functions = [f for f in ast.walk(ast.parse(source)) if isinstance(f, ast.FunctionDef)]
    bodies = [range(f.body[0].lineno, (f.end_lineno or f.lineno) + 1) for f in functions]
    for number in itertools.count():
        put = _Put(number)
        tree = put.visit(ast.parse(source))
        if not put.words:
            return
        assert isinstance(tree, ast.Module)
        inside = sum(put.line in body for body in bodies) == 1
        yield Mutant(number, put.words, ast.fix_missing_locations(tree), inside)


class _Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def __init__(self, name: str, path: Path, tree: ast.Module) -> None:
        self.name, self.path, self.tree = name, path, tree

    def find_spec(self, fullname, path=None, target=None):  # type: ignore[no-untyped-def]
        if fullname != self.name:
            return None
        return importlib.util.spec_from_loader(fullname, self, origin=str(self.path))

    def exec_module(self, module):  # type: ignore[no-untyped-def]
        module.__file__ = str(self.path)
        exec(compile(self.tree, str(self.path), "exec"), module.__dict__)


def _in_fork(passes: Callable[[], bool], limit: float) -> bool:
    child = os.fork()
    if child == 0:
        signal.alarm(math.ceil(limit))
        silence = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silence, 1)
        os.dup2(silence, 2)
        code = 1
        try:
            code = 0 if passes() else 1
        finally:
            os._exit(code)
    return os.waitpid(child, 0)[1] == 0


def survives(path: Path, tree: ast.Module, tests: list[str]) -> bool:
    """Whether all tests pass with this tree for the module, which nobody has imported yet."""

    def passes() -> bool:
        name = ".".join(path.with_suffix("").parts)
        sys.meta_path.insert(0, _Finder(name, path, tree))
        return pytest.main([*_OPTIONS, *tests]) == 0

    return _in_fork(passes, LIMIT_S)


# --- mutants of a function's body: the tests are collected once --------------------------------


class Trials:
    """A plugin that runs what was collected once per mutant, each time in a fork."""

    def __init__(self, path: Path, tree: ast.Module, tries: list[Mutant], until: float) -> None:
        self.path, self.tree, self.tries, self.until = path, tree, tries, until
        self.survivors: list[Mutant] = []
        self.tried = 0
        self.sound = False

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        begun = time.monotonic()
        self.sound = _in_fork(lambda: self._passes(self.tree, session), LIMIT_S)
        limit = 10.0 + 5.0 * (time.monotonic() - begun)
        for one in self.tries if self.sound else ():
            if time.monotonic() > self.until:
                break
            self.tried += 1
            if _in_fork(lambda one=one: self._passes(one.tree, session), limit):  # type: ignore[misc]
                self.survivors.append(one)
                tell(f"{self.path}: {one.number}: {one.words}")
        return True

    def _passes(self, tree: ast.Module, session: pytest.Session) -> bool:
        name = ".".join(self.path.with_suffix("").parts)
        other = ModuleType(name)
        exec(compile(tree, str(self.path), "exec"), other.__dict__)
        try:
            _graft(vars(sys.modules[name]), vars(other), name)
        except ValueError:  # another closure: it cannot be told like this, so it is told
            return True
        return _pass(session)


def _pass(session: pytest.Session) -> bool:
    every = session.items
    for item, following in zip(every, (*every[1:], None), strict=True):
        if any(report.failed for report in runtestprotocol(item, nextitem=following, log=False)):
            return False
    return True


def _graft(old: Mapping[str, Any], new: Mapping[str, Any], module: str) -> None:
    """The bodies of all functions, put into those that were imported long ago."""
    for name, was in old.items():
        for before, after in zip(_functions(was), _functions(new.get(name)), strict=True):
            if before.__module__ == module:
                before.__code__ = after.__code__
        if isinstance(was, type) and was.__module__ == module:
            _graft(vars(was), vars(new[name]), module)


def _functions(one: object) -> list[FunctionType]:
    if isinstance(one, property):
        return [f for f in (one.fget, one.fset, one.fdel) if isinstance(f, FunctionType)]
    if isinstance(one, classmethod | staticmethod):
        return _functions(one.__func__)
    return [one] if isinstance(one, FunctionType) else []


def tell(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def _given() -> argparse.Namespace:
    asked = argparse.ArgumentParser()
    asked.add_argument("module", type=Path)
    asked.add_argument("tests", nargs="+")
    asked.add_argument("--seconds", type=float, default=math.inf)
    asked.add_argument("--only", type=lambda t: [int(n) for n in t.split(",")])
    asked.add_argument("--fresh", action="store_true")
    asked.add_argument("--on", default="local")
    asked.add_argument("--workers", type=int)
    asked.add_argument("--resume", type=Path)
    given = asked.parse_args()
    if given.on == "local" and (given.workers or given.resume):
        asked.error("--workers and --resume are of mutants that are tried elsewhere: say --on")
    return given


def _elsewhere(given: argparse.Namespace, chosen: list[int], most: int, until: float) -> int:
    """Tell what the workers found. The exit code is 1 if some mutants could not be tried."""
    from spread import spread

    from mission.verification.workers.kept import Unusable
    from mission.verification.workers.outcome import Unreachable
    from mission.verification.workers.places import place

    call = (str(given.module), *given.tests, *(["--fresh"] if given.fresh else []))
    noticed = tried = 0
    try:
        at = place(given.on, given.workers, PATIENCE_S)
        for one in spread(call, chosen, at, until, given.resume):
            if isinstance(one, str):
                tell(one)
            else:
                noticed, tried = noticed + one[0], tried + one[1]
    except (Unusable, Unreachable, ValueError) as error:
        tell(str(error))
        return 2
    tell(f"{given.module}: {noticed} of {tried} noticed, {most} mutants in all")
    return 0 if tried == len(chosen) or time.monotonic() > until else 1


def main() -> int:
    given = _given()
    path, tests, until = given.module, given.tests, time.monotonic() + given.seconds
    sys.path[:0] = [str(Path.cwd()), str(Path.cwd() / "tests" / "worlds")]
    for heavy in _HEAVY:
        importlib.import_module(heavy)
    settings.register_profile("mutants", derandomize=True, database=None)
    settings.load_profile("mutants")  # neither chance nor an earlier mutant's failures decide
    source = path.read_text(encoding="utf-8")
    every = list(mutants(source))
    chosen = [m for m in every if given.only is None or m.number in given.only]
    if given.on != "local":
        return _elsewhere(given, [m.number for m in chosen], len(every), until)
    inside = [] if given.fresh else [m for m in chosen if m.inside]
    outside = [m for m in chosen if m not in inside]
    tried = survived = 0
    sound = not outside or survives(path, ast.parse(source), tests)
    for one in outside if sound else ():
        if time.monotonic() < until:
            tried += 1
            if survives(path, one.tree, tests):
                survived += 1
                tell(f"{path}: {one.number}: {one.words}")
    trials = Trials(path, ast.parse(source), inside, until)
    if inside and sound:
        pytest.main([*_OPTIONS, "-s", *tests], plugins=[trials])
        sound = trials.sound
    if not sound:
        tell(f"{path}: its tests fail without any change")
        return 2
    tried, survived = tried + trials.tried, survived + len(trials.survivors)
    tell(f"{path}: {tried - survived} of {tried} noticed, {len(every)} mutants in all")
    return 0


if __name__ == "__main__":
    sys.exit(main())
