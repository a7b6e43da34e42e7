"""The compiled build: hatchling's hook for a wheel, and a copy of the tree beside the pure one.

    AUVMISSION_COMPILED=1 pip install .        a wheel with compiled modules
    python hatch_build.py build/compiled       the tree with them, and an environment that runs it

mypyc translates the modules that ``mission.model.compiled`` lists, and this machine's C compiler
makes one extension of them all. Without the variable the wheel is pure Python.

mypyc ignores other packages: the result depends on this tree alone, whatever is installed. The
copy that is compiled is changed before, and restored after; no source needs mypyc. The changes:

- Classes are marked so that interpreted classes may inherit from them. Marked classes can also be
  copied (others only if their constructor takes no argument).
- Dataclasses get the types of their fields again, because mypyc loses them.
- Frozen dataclasses get a way to be copied and pickled: mypyc would set their fields one by one.
- Constants are marked as final: mypyc then inlines numbers, and reads the others without a
  dictionary lookup.

Contraction is off. A fused multiply-add rounds once instead of twice, so aarch64 would differ from
x86-64 in the last bit.
"""

from __future__ import annotations

import ast
import os
import re
import runpy
import shutil
import sys
import sysconfig
import venv
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import chdir, contextmanager
from pathlib import Path
from typing import Any

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ImportError:  # run as a script
    BuildHookInterface = object

LIST = "mission.model.compiled"
WANTED = "AUVMISSION_COMPILED"
PACKAGES = ("mission", "links", "protocol")
NEEDED = ["mypy>=1.18", "setuptools>=65"]
CHECKING = ["--config-file=", "--no-site-packages", "--ignore-missing-imports"]
FLAGS = ["-ffp-contract=off"]
_MARK = "@mypyc_attr(allow_interpreted_subclasses=True)\n"
# Bases of the classes that others inherit from, or copy.
_BASES = "ABC|EngineState|Flying|LockStep|Rig|Watch"
_CLASS = re.compile(rf"^(?=class \w+(\(({_BASES})\))?:)", re.MULTILINE)
_FUTURE = re.compile(r"^(from __future__ import annotations\n)", re.MULTILINE)
_IMPORT = """from typing import TYPE_CHECKING, Final
if TYPE_CHECKING:
    from mypy_extensions import mypyc_attr
"""
_CONSTANT = re.compile(r"_?[A-Z][A-Z0-9_]*")
LEFT = {".git", ".venv", ".mypy_cache", ".ruff_cache", ".pytest_cache", "build", "dist", "out"}


def compile_in(folder: Path) -> list[Path]:
    """Compile the tree in ``folder`` in place and return its extensions, relative to it. The one
    with the code of all is at its top. Raises setuptools' CompileError without a compiler."""
    from setuptools import Distribution
    from setuptools.command.build_ext import build_ext

    class OnAllCores(build_ext):  # type: ignore[misc]
        def build_extensions(self) -> None:
            self.compiler.compile = at_once(self.compiler.compile, os.cpu_count() or 1)
            super().build_extensions()

    with chdir(folder), marked(_sources(folder)) as sources:
        extensions = translated(sources)
        command: Any = OnAllCores(Distribution({"ext_modules": extensions}))
        command.inplace = True
        command.ensure_finalized()
        command.run()
    return [Path(command.get_ext_filename(extension.name)) for extension in extensions]


def at_once(compile_: Callable[..., list[str]], cores: int) -> Callable[..., list[str]]:
    """A compiler's ``compile`` that runs ``cores`` compilers at a time, one C file each."""

    def of_all(sources: list[str], **options: Any) -> list[str]:
        with ThreadPoolExecutor(cores) as threads:
            made = threads.map(lambda source: compile_([source], **options), sources)
            return [file for files in made for file in files]

    return of_all


def translate_in(folder: Path) -> None:
    """Only generate the C code, in ``folder``: shows whether mypyc accepts the sources, in a sixth
    of the time."""
    with chdir(folder), marked(_sources(folder)) as sources:
        translated(sources)


def translated(sources: list[Path]) -> list[Any]:
    """Return the extensions to compile. Ends the program with mypyc's errors if it refuses them."""
    from mypyc.build import mypycify

    extensions = mypycify(
        [*CHECKING, *map(str, sources)],
        opt_level="2",
        debug_level="0",
        multi_file=True,
        group_name="auvmission",
    )
    for extension in extensions:
        extension.extra_compile_args += FLAGS
    return extensions


def _sources(folder: Path) -> list[Path]:
    """The source files of the modules that the tree in ``folder`` lists, relative to it."""
    sys.path.insert(0, str(folder))
    path = folder.joinpath(*LIST.split(".")).with_suffix(".py")
    return [
        Path(*name.split(".")).with_suffix(".py") for name in runpy.run_path(str(path))["MODULES"]
    ]


@contextmanager
def marked(sources: list[Path]) -> Iterator[list[Path]]:
    """Mark the sources in the ``with`` block, and restore them after it. Marked are constants,
    classes without a base, and classes with a base of ``_BASES``."""
    before = {source: source.read_text() for source in sources}
    try:
        for source, text in before.items():
            copied = _FUTURE.sub(r"\1" + _IMPORT, finals(text), count=1)
            source.write_text(_CLASS.sub(_MARK, copied) + told_again(text))
        yield sources
    finally:
        for source, text in before.items():
            source.write_text(text)


def finals(text: str) -> str:
    """The module with its constants marked as ``Final``. Constants are names in capitals that are
    assigned once: alone, or several in one statement, from a tuple or a range. No line moves."""
    tree, lines = ast.parse(text), text.splitlines(keepends=True)
    once = _given_once(tree)
    for node in tree.body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or not once.issuperset(_names(node)):
            continue
        if isinstance(node, ast.AnnAssign) and node.value is not None:
            _insert(lines, node.annotation.lineno, node.annotation.end_col_offset, "]")
            _insert(lines, node.annotation.lineno, node.annotation.col_offset, "Final[")
        elif isinstance(node, ast.AnnAssign) or len(node.targets) > 1:
            continue
        elif isinstance(node.targets[0], ast.Name):
            _insert(lines, node.lineno, node.targets[0].end_col_offset, ": Final")
        elif node.lineno == node.end_lineno and (values := _values(node)):
            pairs = zip(_names(node), values, strict=True)
            line = "; ".join(f"{name}: Final = {value}" for name, value in pairs)
            lines[node.lineno - 1] = line + "\n"
    return "".join(lines)


def _given_once(tree: ast.Module) -> set[str]:
    """Names in capitals that the module assigns only once."""
    plain = [n for n in tree.body if not isinstance(n, ast.FunctionDef | ast.ClassDef)]
    stored = Counter(
        node.id
        for node in (inner for top in plain for inner in ast.walk(top))
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    )
    others = {name for n in ast.walk(tree) if isinstance(n, ast.Global) for name in n.names}
    found = {name for name, times in stored.items() if times == 1 and _CONSTANT.fullmatch(name)}
    return found - others


def _names(node: ast.Assign | ast.AnnAssign) -> list[str]:
    """The targets of the assignment, as source text."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    parts = targets[0].elts if isinstance(targets[0], ast.Tuple) else targets
    return [ast.unparse(part) for part in parts]


def _values(node: ast.Assign) -> list[str]:
    """The values that several names get, as source text; empty if they cannot be told."""
    match node.value:
        case ast.Tuple(elts=parts):
            return list(map(ast.unparse, parts))
        case ast.Call(func=ast.Name(id="range"), args=args) if _are_numbers(args):
            return list(map(str, range(*map(ast.literal_eval, args))))
    return []


def _are_numbers(values: list[ast.expr]) -> bool:
    return all(isinstance(value, ast.Constant) for value in values)


def _insert(lines: list[str], number: int, column: int | None, words: str) -> None:
    line = lines[number - 1]
    lines[number - 1] = line[:column] + words + line[column:]


def told_again(text: str) -> str:
    """Lines that give the module's dataclasses the types of their fields again, and frozen ones a
    way to be pickled. mypyc keeps only ``tuple`` of ``tuple[float, ...]``, but records are read
    back by these types."""
    lines = []
    for node in ast.parse(text).body:
        if isinstance(node, ast.ClassDef) and "dataclass" in map(_called, node.decorator_list):
            fields = {
                ast.unparse(line.target): ast.unparse(line.annotation)
                for line in node.body
                if isinstance(line, ast.AnnAssign)
            }
            lines.append(f'vars({node.name})["__annotations__"].update({fields!r})\n')
            if any("frozen=True" in ast.unparse(each) for each in node.decorator_list):
                values = "".join(f"it.{field}, " for field in fields)
                made = f"lambda it: ({node.name}, ({values}))"
                lines.append(f'__import__("copyreg").pickle({node.name}, {made})\n')
    return "".join(lines)


def _called(decorator: ast.expr) -> str:
    return ast.unparse(decorator.func if isinstance(decorator, ast.Call) else decorator)


class CustomBuildHook(BuildHookInterface):  # type: ignore[misc, valid-type]
    """The build hook. Hatchling finds it by its name."""

    def dependencies(self) -> list[str]:
        return NEEDED if os.environ.get(WANTED) else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version != "standard" or not os.environ.get(WANTED):
            return
        tree = Path(self.root) / "build" / "wheel"
        copy(Path(self.root), tree, PACKAGES)
        build_data["force_include"] |= {str(tree / file): str(file) for file in compile_in(tree)}
        build_data |= {"pure_python": False, "infer_tag": True}


# --- beside the pure tree ---


def copy(root: Path, tree: Path, names: tuple[str, ...]) -> None:
    """Copy the sources ``names`` into ``tree``, in place of earlier copies."""
    for name in names:
        shutil.rmtree(tree / name, ignore_errors=True)
        source = root / name
        if source.is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(source, tree / name, ignore=ignored)
        else:
            shutil.copy2(source, tree / name)


def environment(tree: Path) -> None:
    """Make a virtual environment in ``tree``. It sees the running environment's packages, but
    takes auvmission's own from ``tree``."""
    folder = tree / ".venv"
    venv.create(folder, symlinks=True)
    packages = Path(sysconfig.get_path("purelib", vars={"base": str(folder)}))
    packages.joinpath("auvmission.pth").write_text(f"{tree}\n{sysconfig.get_path('purelib')}\n")
    for name in ("auvmission", "pytest"):
        script = Path(sys.executable).parent.joinpath(name).read_text().split("\n", 1)[1]
        program = folder / "bin" / name
        program.write_text(f"#!{folder}/bin/python\n{script}")
        program.chmod(0o755)


def main(folder: str) -> int:
    root, tree = Path(__file__).resolve().parent, Path(folder).resolve()
    tree.mkdir(parents=True, exist_ok=True)
    copy(root, tree, tuple(p.name for p in root.iterdir() if p.name not in LEFT))
    compile_in(tree)
    environment(tree)
    return 0


if __name__ == "__main__":
    raise SystemExit(main(*sys.argv[1:]))
