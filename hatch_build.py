"""The compiled build: hatchling's hook for a wheel, and a tree in which that wheel is installed.

    AUVMISSION_COMPILED=1 pip install .        a wheel with compiled modules
    python hatch_build.py build/compiled       that wheel installed, with its tests beside it

mypyc translates the modules that ``mission.model.compiled`` lists, and this machine's C compiler
makes one extension of them all. Without the variable, or without a compiler, the wheel is pure
Python. An editable install is always pure.

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
import hashlib
import os
import re
import shutil
import subprocess
import sys
import venv
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import chdir, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ImportError:  # run as a script
    BuildHookInterface = object

LIST = Path("mission", "model", "compiled.py")
WANTED = "AUVMISSION_COMPILED"
NO_COMPILER = "no C compiler that finds Python.h: the wheel is pure Python"
PACKAGES = ("mission", "links", "protocol")
INSTALLED = {name: name for name in PACKAGES} | {"missions": "mission/missions"}  # in a wheel
MADE_OF = Path("wheel", "made-of")  # in the tree: the digest of the sources of its wheel
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
CACHES = {".mypy_cache", ".ruff_cache", ".pytest_cache", ".import_linter_cache"}
LEFT = {*CACHES, "__pycache__", ".git", ".venv", "build", "dist", "out"}


def has_compiler() -> bool:
    """Whether this machine's C compiler can build a Python extension."""
    from setuptools import Distribution, Extension
    from setuptools.command.build_ext import build_ext
    from setuptools.errors import CompileError, LinkError, PlatformError

    with TemporaryDirectory() as folder:
        source = Path(folder) / "tried.c"
        source.write_text("#include <Python.h>\n")
        command: Any = build_ext(Distribution({"ext_modules": [Extension("tried", [str(source)])]}))
        command.build_lib = command.build_temp = folder
        command.ensure_finalized()
        try:
            command.run()
        except (CompileError, LinkError, PlatformError):
            return False
    return True


def compile_in(folder: Path) -> list[Path]:
    """Compile the tree in ``folder`` in place and return its extensions, relative to it. The one
    with the code of all is at its top."""
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
    for node in ast.parse((folder / LIST).read_text()).body:
        if isinstance(node, ast.Assign) and _names(node) == ["MODULES"]:
            names = ast.literal_eval(node.value)
            return [Path(*name.split(".")).with_suffix(".py") for name in names]
    raise ValueError(f"{LIST} has no MODULES")


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
    """The build hook. Hatchling loads it because pyproject.toml has a table for it."""

    def dependencies(self) -> list[str]:
        return NEEDED if os.environ.get(WANTED) else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version != "standard" or not os.environ.get(WANTED):
            return
        if not has_compiler():
            self.app.display_warning(f"{WANTED} is set, but there is {NO_COMPILER}")
            return
        tree = Path(self.root) / "build" / "wheel"
        copy(Path(self.root), tree, PACKAGES)
        build_data["force_include"] |= {str(tree / file): str(file) for file in compile_in(tree)}
        build_data |= {"pure_python": False, "infer_tag": True}


# --- the wheel, installed, with its tests beside it ---


def copy(root: Path, tree: Path, names: Iterable[str]) -> None:
    """Copy the sources ``names`` into ``tree``, in place of earlier copies."""
    for name in names:
        shutil.rmtree(tree / name, ignore_errors=True)
        source = root / name
        if source.is_dir():
            ignored = shutil.ignore_patterns("__pycache__", "node_modules")
            shutil.copytree(source, tree / name, ignore=ignored)
        else:
            shutil.copy2(source, tree / name)


def digest(root: Path) -> str:
    """A digest of every file that the wheel depends on."""
    found = [path for name in INSTALLED for path in (root / name).rglob("*")]
    files = [path for path in found if path.is_file() and "__pycache__" not in path.parts]
    whole = hashlib.sha256()
    for path in sorted([*files, root / "hatch_build.py", root / "pyproject.toml"]):
        content = path.read_bytes()
        whole.update(f"{path.relative_to(root)} {len(content)}\n".encode() + content)
    return whole.hexdigest()


def outdated(root: Path, tree: Path) -> str:
    """Why the build in ``tree`` is not one of the sources in ``root``; empty if it is."""
    made_of = tree / MADE_OF
    if not made_of.exists():
        return "there is no compiled build: make compiled"
    if made_of.read_text() != digest(root):
        return "the compiled build is of other sources: make compiled"
    return ""


def install(root: Path, tree: Path) -> None:
    """Build the wheel and install it in a fresh environment in ``tree``, with the packages that its
    tests and benches need. Ends the program if the wheel is pure Python."""
    wheels, folder = tree / "wheel", tree / ".venv"
    shutil.rmtree(wheels, ignore_errors=True)
    words = ("wheel", "--quiet", "--no-deps", "--wheel-dir", str(wheels), str(root))
    wanted = os.environ | {WANTED: "1"}
    subprocess.run([sys.executable, "-m", "pip", *words], check=True, env=wanted)
    (wheel,) = wheels.glob("*.whl")
    if wheel.stem.endswith("-none-any"):
        raise SystemExit(NO_COMPILER)
    venv.create(folder, clear=True, symlinks=True, with_pip=True)
    words = ("install", "--quiet", f"{wheel}[bench,dev]")
    subprocess.run([str(folder / "bin" / "python"), "-m", "pip", *words], check=True)


def link(tree: Path) -> None:
    """Link the installed packages where the sources would be, so that the tests run only those."""
    (packages,) = tree.glob(".venv/lib/python*/site-packages")
    for name, place in INSTALLED.items():
        if (tree / name).is_symlink():
            (tree / name).unlink()
        shutil.rmtree(tree / name, ignore_errors=True)
        (tree / name).symlink_to((packages / place).relative_to(tree))


def main(folder: str) -> int:
    root, tree = Path(__file__).resolve().parent, Path(folder).resolve()
    if root.is_relative_to(tree):
        raise SystemExit(f"{tree} has the sources; name a folder that can be replaced")
    tree.mkdir(parents=True, exist_ok=True)
    if outdated(root, tree):
        install(root, tree)
        (tree / MADE_OF).write_text(digest(root))
    link(tree)
    copy(root, tree, {path.name for path in root.iterdir()} - LEFT - INSTALLED.keys())
    return 0


if __name__ == "__main__":
    raise SystemExit(main(*sys.argv[1:]))
