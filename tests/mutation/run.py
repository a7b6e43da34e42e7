"""Mutation testing of one module: change one thing at a time, and see whether its tests notice.

    python tests/mutation/run.py mission/machine.py tests/mission/test_machine.py ... [--seconds N]

Everything heavy is imported once; each mutant is a fork of that process in which the module is
compiled from the mutated tree, so no file is ever changed. Prints a line per survivor, and the
score. What is mutated: comparisons, boolean and arithmetic operators, ``not``, numbers, True and
False, returned values, and calls that stand alone.
"""

from __future__ import annotations

import ast
import contextlib
import copy
import importlib.abc
import importlib.machinery
import importlib.util
import io
import os
import signal
import sys
import time
from collections.abc import Iterator
from pathlib import Path

LIMIT_S = 120  # of one mutant's tests: beyond, it hangs, which was noticed
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
        self.words = ""

    def visit(self, node: ast.AST) -> ast.AST:
        _strip(node)
        if isinstance(node, _Kept):
            return node
        for words, other in variants(node):
            if self.seen == self.wanted:
                self.words = f"line {node.lineno}: {ast.unparse(node)}  ->  {words}"  # type: ignore[attr-defined]
                self.seen += 1
                return ast.copy_location(other, node)
            self.seen += 1
        return super().generic_visit(node)


def mutant(source: str, number: int) -> tuple[str, ast.Module] | None:
    put = _Put(number)
    tree = put.visit(ast.parse(source))
    assert isinstance(tree, ast.Module)
    return (put.words, ast.fix_missing_locations(tree)) if put.words else None


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


def survives(path: Path, tree: ast.Module, tests: list[str]) -> bool:
    """In a fork: whether all tests pass with this tree for the module."""
    child = os.fork()
    if child == 0:
        signal.alarm(LIMIT_S)
        name = ".".join(path.with_suffix("").parts)
        sys.meta_path.insert(0, _Finder(name, path, tree))
        code = 1
        try:
            import pytest

            quiet = io.StringIO()
            with contextlib.redirect_stdout(quiet), contextlib.redirect_stderr(quiet):
                code = pytest.main([*_OPTIONS, *tests])
        finally:
            os._exit(0 if code == 0 else 1)
    return os.waitpid(child, 0)[1] == 0


def tell(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def main() -> int:
    words = sys.argv[1:]
    seconds = float(words[words.index("--seconds") + 1]) if "--seconds" in words else 1e9
    words = words[: words.index("--seconds")] if "--seconds" in words else words
    path, tests = Path(words[0]), words[1:]
    sys.path[:0] = [str(Path.cwd()), str(Path.cwd() / "tests" / "mission")]
    for heavy in ("pytest", "hypothesis", "numpy", "filterpy.kalman", "transitions.extensions"):
        importlib.import_module(heavy)
    source, begun = path.read_text(encoding="utf-8"), time.monotonic()
    if not survives(path, ast.parse(source), tests):
        tell(f"{path}: its tests fail without any change")
        return 2
    number = killed = 0
    while (found := mutant(source, number)) and time.monotonic() - begun < seconds:
        number += 1
        if survives(path, found[1], tests):
            tell(f"{path}: {found[0]}")
        else:
            killed += 1
    total = number
    while mutant(source, total):
        total += 1
    tell(f"{path}: {killed} of {number} noticed, {total} mutants in all")
    return 0


if __name__ == "__main__":
    sys.exit(main())
