"""Imports at run time go one way: each layer (tools/layers.py) may import only what stands below it.

An import under `if TYPE_CHECKING` may point up: the type that a part is given is named there, wherever it is defined.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from tools.layers import LAYERS, PURE

pytestmark = pytest.mark.structure

ROOT = Path(__file__).resolve().parent.parent

IMPURE_MODULES = {
    "socket",
    "threading",
    "selectors",
    "select",
    "asyncio",
    "subprocess",
    "time",
    "queue",
    "signal",
}
ALLOWED_IMPURE = {
    # A lock around the class cache and the paused collector; no waiting happens there.
    ("rosproto.codec", "threading"),
}


def layer_of(module: str) -> str | None:
    """The longest layer name that `module` belongs to; None for modules of other projects."""
    matches = [name for name in LAYERS if module == name or module.startswith(name + ".")]
    return max(matches, key=len) if matches else None


def sources() -> Iterator[tuple[str, Path]]:
    for package in ("rosproto", "woosh_pure", "msgdefs"):
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), path


def type_checking_blocks(tree: ast.AST) -> set[ast.AST]:
    found: set[ast.AST] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            for statement in node.body:
                found.update(ast.walk(statement))
    return found


@cache
def parsed(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"))


def imports_of(module: str, path: Path) -> Iterator[tuple[str, int]]:
    """Every module that a file imports at run time, with its line, relative imports resolved."""
    tree = parsed(path)
    skipped = type_checking_blocks(tree)
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(tree):
        if node in skipped:
            continue
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, node.lineno
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*parents, base]) if base else ".".join(parents)
            for alias in node.names:
                joined = f"{base}.{alias.name}"
                yield (joined if layer_of(joined) != layer_of(base) else base), node.lineno


MODULES = list(sources())
PURE_MODULES = [(name, path) for name, path in MODULES if layer_of(name) in PURE]


def wrong_imports(module: str, path: Path) -> Iterator[str]:
    """Those that point up."""
    own = layer_of(module)
    if own is None:
        yield f"{module} belongs to no layer: add it to LAYERS"
        return
    if module in {"rosproto", "rosproto.__main__"}:
        return  # the face gathers everything
    for imported, line in imports_of(module, path):
        target = layer_of(imported)
        if target is None:
            continue
        if LAYERS.index(target) > LAYERS.index(own) or (target == "rosproto" and own != "woosh_pure"):
            yield f"{path.relative_to(ROOT)}:{line} imports {imported}"


@pytest.mark.slow  # reads all sources
def test_a_module_imports_only_what_is_below_it() -> None:
    """No import points up, and none of the layers imports the public face."""
    assert len(MODULES) > 300
    assert [wrong for module, path in MODULES for wrong in wrong_imports(module, path)] == []


def test_pure_layers_know_no_sockets_threads_or_clocks() -> None:
    """The protocol, the codec and the definitions are values in, values out."""
    assert len(PURE_MODULES) > 40
    assert [
        f"{path.relative_to(ROOT)}:{line} imports {name}"
        for module, path in PURE_MODULES
        for name, line in imports_of(module, path)
        if name.partition(".")[0] in IMPURE_MODULES and (layer_of(module), name) not in ALLOWED_IMPURE
    ] == []


def test_the_watch_itself_sees_a_wrong_import(tmp_path: Path) -> None:
    """A check that cannot fail checks nothing."""
    bad = tmp_path / "bad.py"
    bad.write_text("from rosproto.node import Node\nfrom ..node import publisher\n")
    found = [name for name, _ in imports_of("rosproto.msg.bad", bad)]
    assert found[0].startswith("rosproto.node")
    assert LAYERS.index("rosproto.node") > LAYERS.index("rosproto.msg")
    assert layer_of(found[1]) == "rosproto.node"


NODE = {name: path for name, path in MODULES if name.startswith("rosproto.node")}
GROUND_ROOMS = {"graph", "definitions"}
"""Rooms of rosproto.node that know none of the others."""


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Every statement, however deep; expressions, which are most of a tree, hold none."""
    todo = [tree]
    while todo:
        for child in ast.iter_child_nodes(todo.pop()):
            if isinstance(child, (ast.stmt, ast.excepthandler, ast.match_case)):
                yield child
                todo.append(child)


def run_time_statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Those that are executed: what is imported for types alone is left out."""
    skipped = type_checking_blocks(tree)
    return (node for node in statements(tree) if node not in skipped)


def test_a_statement_is_found_however_deep_it_stands() -> None:
    source = Path(__file__).read_text("utf-8") + (
        "\ntry:\n  with x:\n    pass\nexcept E:\n  match y:\n    case 1:\n      import deep\n"
    )
    tree = ast.parse(source)
    of_all = {node for node in ast.walk(tree) if isinstance(node, ast.stmt)}
    assert {node for node in statements(tree) if isinstance(node, ast.stmt)} == of_all


def test_an_import_for_types_alone_does_not_count() -> None:
    """Neither for the layers nor for the cycles; one that is executed counts, however late."""
    source = (
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n  import up\nelse:\n  import down\n"
        "def late():\n  import later\n"
    )
    found = [node for node in run_time_statements(ast.parse(source)) if isinstance(node, ast.Import)]
    assert {alias.name for node in found for alias in node.names} == {"down", "later"}


def imports_within(module: str, files: dict[str, Path]) -> set[str]:
    """Which of some files one of them imports at run time, late imports included."""
    found = set()
    for node in run_time_statements(parsed(files[module])):
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found |= {name if name in files else node.module for name in names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return (found & set(files)) - {module}


@cache
def node_imports() -> dict[str, set[str]]:
    return {module: imports_within(module, NODE) for module in NODE}


def room(module: str) -> str:
    """ "graph" of rosproto.node.graph.slave_api; the module itself for what stands in no room."""
    parts = module.split(".")
    return parts[2] if len(parts) > 3 else module


def reachable(start: str, imports: dict[str, set[str]]) -> set[str]:
    """What a file imports, and what that imports, and so on."""
    found: set[str] = set()
    todo = [start]
    while todo:
        new = imports[todo.pop()] - found
        found |= new
        todo += new
    return found


def cycles(imports: dict[str, set[str]], but: frozenset[str] = frozenset()) -> dict[str, list[str]]:
    """Files that need each other, by way of others too."""
    reached = {module: reachable(module, imports) for module in imports}
    found = {
        module: sorted(other for other in others if module in reached[other] and other not in but)
        for module, others in reached.items()
    }
    return {module: others for module, others in found.items() if others}


def test_a_cycle_is_seen() -> None:
    """A check that cannot fail checks nothing."""
    assert cycles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == {key: ["a", "b", "c"] for key in "abc"}


def test_no_files_of_the_node_import_one_another() -> None:
    """Late imports count, too: of two files one can be loaded, and tested, without the other."""
    assert len(node_imports()) > 20
    assert cycles(node_imports()) == {}


def test_nothing_below_the_node_names_it() -> None:
    """Parts are given what they need (`parts.py`), not the node."""
    naming = {module for module, imports in node_imports().items() if "rosproto.node.node" in imports}
    assert naming <= {"rosproto.node"}  # the package's face


def test_the_ground_rooms_of_the_node_know_no_other() -> None:
    """The graph and definitions are what topics, services and parameters stand on."""
    ground = [module for module in NODE if room(module) in GROUND_ROOMS]
    assert len(ground) > 5
    for module in ground:
        assert "rosproto.node.context" not in node_imports()[module], module
        above = {name for name in node_imports()[module] if name != room(name)} - {module}
        assert {room(name) for name in above} <= GROUND_ROOMS, module


GATEWAY = {name: path for name, path in MODULES if name.startswith("rosproto.gateway")}


def test_no_files_of_the_gateway_import_one_another() -> None:
    """Late imports count, too."""
    imports = {module: imports_within(module, GATEWAY) for module in GATEWAY}
    assert len(imports) > 40
    assert cycles(imports) == {}


CHASSIS = {name: path for name, path in MODULES if name.startswith("woosh_pure")}
TWO_FACES = frozenset({"woosh_pure.chassis", "woosh_pure.aio", "woosh_pure.aio.chassis"})
"""`Chassis.aio` is an `aio.Chassis`, and that one's `chassis` a `Chassis`: as users see them, they name each other."""


@cache
def chassis_imports() -> dict[str, set[str]]:
    return {module: imports_within(module, CHASSIS) for module in CHASSIS}


def test_no_two_files_of_the_chassis_need_each_other() -> None:
    """Late imports count, too: what is used below is handed down."""
    assert len(chassis_imports()) > 100
    assert cycles(chassis_imports(), TWO_FACES) == {}


def test_only_the_command_imports_the_command() -> None:
    """What the page, the fleet or the library shares with it sits lower."""
    for module, imports in chassis_imports().items():
        if module != "woosh_pure.__main__" and not module.startswith("woosh_pure.cli"):
            assert not {name for name in imports if name.startswith("woosh_pure.cli")}, module


CHASSIS_FLOORS = [
    "hints language toml_text",
    "enums firmware geometry interface lease reasons",
    "faults",
    "outcome values",
    "errors maps",
    "robot_api",
    "connection served_graph state_file",
    "feed",
    "doctor readiness stopping",
    "components",
    "motion readings velocity",
    "api_bridge peripherals sim",
    "missions",
    "chassis",
    "aio api_server fleet foxglove selftest web woosh_pure",
    "mcp",
    "cli pytest_plugin",
    "__main__",
]
"""The rooms of woosh_pure from the ground up: folders, and files that stand in none. `woosh_pure` is its face."""
FLOOR_OF = {room: floor for floor, rooms in enumerate(CHASSIS_FLOORS) for room in rooms.split()}


def chassis_room(module: str) -> str:
    """ "stopping" of woosh_pure.stopping.immediate_stop; "woosh_pure" of the package's own face."""
    return module.split(".")[1] if "." in module else module


def test_the_floors_of_the_chassis_name_every_room_once() -> None:
    named = " ".join(CHASSIS_FLOORS).split()
    assert sorted(named) == sorted({chassis_room(module) for module in CHASSIS})


def test_a_room_of_the_chassis_imports_lower_floors_only() -> None:
    """Late imports count, too: whoever loads a room loads only what is below it."""
    for module, imports in chassis_imports().items():
        own = chassis_room(module)
        others = imports if module not in TWO_FACES else set()
        others = {other for other in others if chassis_room(other) != own}
        assert not {other for other in others if FLOOR_OF[chassis_room(other)] >= FLOOR_OF[own]}, module


def test_what_is_covered_by_branches_is_there() -> None:
    """A file that was moved would not be measured any more, and nobody would notice."""
    table = (
        (ROOT / "pyproject.toml").read_text("utf-8").partition("[tool.coverage.run]")[2].partition("\n[")[0]
    )
    patterns = re.findall(r'"([^"]+)"', table)
    assert len(patterns) > 5
    assert [pattern for pattern in patterns if not list(ROOT.glob(pattern))] == []
