"""The layers of the house: who may import whom, and what the core must not touch."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[1] / "src" / "fidmap"
MOST_LINES = 450

# every room and what it may import; a room that is not listed here fails the test
FILE_HELPERS = {"text_file", "yaml_file", "csv_file", "file_schema", "output_file", "angles"}
ALLOWED: dict[str, set[str]] = {
    "version": set(),
    "model": set(),
    "angles": set(),
    "geometry": {"model"},
    "grid": {"model"},
    "scoring": {"model"},
    "detect": {"model", "geometry", "grid"},
    "register": {"model", "geometry", "scoring"},
    "attributes": {"model", "geometry", "scoring"},
    "uncertainty": {"model", "geometry", "scoring"},
    "synth": {"model", "geometry", "grid"},
    "evaluate": {"model", "grid", "detect", "register", "attributes", "uncertainty", "version"},
    "ranking": {"model"},
    "text_file": {"model"},
    "yaml_file": {"model", "text_file"},
    "csv_file": {"model", "text_file"},
    "file_schema": {"text_file"},
    "output_file": {"model"},
    "maps": {"model", "grid"} | FILE_HELPERS,
    "arena": {"model", "geometry"} | FILE_HELPERS,
    "profiles": {"model"} | FILE_HELPERS,
    "object_list": {"model"} | FILE_HELPERS,
    "points": {"model", "object_list"} | FILE_HELPERS,
    "human": {"model", "ranking"} | FILE_HELPERS,
    "schemas": {"arena", "profiles", "points"},
}
CORE = {
    "version", "model", "geometry", "grid", "scoring", "detect", "register", "attributes", "uncertainty", "evaluate",
    "ranking",
}  # fmt: skip
LIBRARY = {*ALLOWED, "evaluate", "ranking"}
ALLOWED["report"] = LIBRARY - {"detect", "register", "attributes", "synth", "evaluate", "schemas"}
ALLOWED["inspect"] = LIBRARY - {"synth", "schemas", "human", "ranking"}
ALLOWED["study"] = (LIBRARY - {"schemas"}) | {"report", "inspect"}
ALLOWED["cli"] = LIBRARY | {"report", "study", "inspect"}
ALLOWED["__main__"] = {"cli"}
ALLOWED["__init__"] = LIBRARY

PURE = {
    "abc", "bisect", "collections", "cv2", "dataclasses", "enum", "functools", "itertools", "math", "numpy", "operator",
    "scipy", "typing", "__future__",
}  # fmt: skip
# the network's weights lie beside its code and are read as a resource of the package
EXTRA = {"detect/network.py": {"importlib"}}
RANDOM = {"seed", "rand", "randn", "random", "normal", "uniform", "choice", "shuffle", "permutation", "RandomState"}


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def files() -> list[Path]:
    return sorted(SOURCE.rglob("*.py"))


def shown(path: Path) -> str:
    return path.relative_to(SOURCE).as_posix()


def room_of(path: Path) -> str:
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def imports(nodes: Iterator[ast.AST]) -> Iterator[tuple[int, str]]:
    """Line and full name of every imported module; relative ones are refused by ruff."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.lineno, node.module
            if (SOURCE.parent / Path(*node.module.split("."))).is_dir():
                yield from ((node.lineno, f"{node.module}.{alias.name}") for alias in node.names)


def ours(module: str) -> str | None:
    """The room of one of our modules; None for the package itself and for others' modules."""
    parts = module.split(".")
    if parts[0] != "fidmap" or len(parts) == 1:
        return None
    return parts[1] if (SOURCE / parts[1]).is_dir() or (SOURCE / f"{parts[1]}.py").is_file() else None


@pytest.mark.parametrize("path", files(), ids=shown)
def test_rooms_import_from_lower_layers_only(path: Path) -> None:
    """The allow-list above, inside functions and type checks too."""
    room = room_of(path)
    assert room in ALLOWED, f"room {room} is new: say in this test what it may import"

    wrong = [
        f"{shown(path)}:{line} imports {module}"
        for line, module in imports(ast.walk(tree(path)))
        if (there := ours(module)) is not None and there != room and there not in ALLOWED[room]
    ]

    assert wrong == []


@pytest.mark.parametrize("path", [p for p in files() if room_of(p) in CORE], ids=shown)
def test_the_core_knows_neither_files_nor_clocks_nor_loggers(path: Path) -> None:
    """Values in, values out: only modules that compute, no open(), no global randomness."""
    modules = {name.split(".")[0] for _, name in imports(ast.walk(tree(path)))}
    called = [n.func for n in ast.walk(tree(path)) if isinstance(n, ast.Call)]

    assert modules - {"fidmap"} <= PURE | EXTRA.get(shown(path), set())
    assert not [f for f in called if isinstance(f, ast.Name) and f.id in {"open", "input", "eval", "exec"}]
    assert not [f for f in called if ast.unparse(f).rpartition(".")[::2] in {("np.random", name) for name in RANDOM}]
    assert not [f for f in called if ast.unparse(f) in {"cv2.imread", "cv2.imwrite", "np.load", "np.save"}] or (
        shown(path) in EXTRA
    )


@pytest.mark.parametrize("path", [p for p in files() if room_of(p) == "synth"], ids=shown)
def test_artificial_maps_take_their_randomness_as_an_argument(path: Path) -> None:
    """No draw from numpy's global generator, no unseeded one."""
    calls = [n for n in ast.walk(tree(path)) if isinstance(n, ast.Call)]
    names = [ast.unparse(c.func) for c in calls]

    assert not [n for n in names if n in {f"np.random.{word}" for word in RANDOM}]
    assert not [c for c, n in zip(calls, names, strict=True) if n == "np.random.default_rng" and not c.args]


def top_level(path: Path) -> Iterator[ast.AST]:
    """Nodes that run on import: neither bodies of functions nor what only a type checker sees."""
    waiting: list[ast.AST] = list(tree(path).body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            continue
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            continue
        yield node
        waiting.extend(ast.iter_child_nodes(node))


def module_of(path: Path) -> str:
    parts = ("fidmap", *path.relative_to(SOURCE).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def test_no_import_cycles() -> None:
    """Module by module, for what is imported on import."""
    known = {module_of(path) for path in files()}
    needs = {
        module_of(path): {name for _, name in imports(top_level(path)) if name in known} - {module_of(path)}
        for path in files()
    }
    for path in files():  # a package's own file may name its parts; its parts may name the package's values
        if path.name == "__init__.py" and (package := module_of(path)) != "fidmap":
            for part in needs[package]:
                if part.startswith(package + "."):
                    needs[part].discard(package)
    needs.pop("fidmap")
    while free := {name for name, others in needs.items() if not others & set(needs)}:
        needs = {name: others for name, others in needs.items() if name not in free}

    assert needs == {}


@pytest.mark.parametrize("path", files(), ids=shown)
def test_no_print_and_no_long_files(path: Path) -> None:
    """What is for people goes through the command line's console; long files are taken apart."""
    printed = [n for n in ast.walk(tree(path)) if isinstance(n, ast.Call) and ast.unparse(n.func) == "print"]

    assert printed == []
    assert len(path.read_text(encoding="utf-8").splitlines()) <= MOST_LINES
