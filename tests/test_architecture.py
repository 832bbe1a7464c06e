"""The rules that keep the parts apart, read from the source itself.

They follow from the folders: a folder with an ``__init__.py`` is a package, what its ``__init__.py`` imports is its
face, and what lies beside each other imports one way.
"""

from __future__ import annotations

import ast
import importlib.metadata
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

import osm2xodr

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "osm2xodr"
STAGES = {"osmParsing", "surface", "geometry", "furniture", "xodrWriter"}

# The folders whose modules may import these libraries.
HOMES = {
    "click": {"cli"},
    "PIL": {"viewing.picture"},
    "osmium": {"osmParsing.file", "batching.cutting", "fetching"},
    "rasterio": {"system", "fetching"},
    "shapely": {"exporting", "exporting.scene"},
    "geopandas": {"exporting"},
    "networkx": {"exporting"},
    "pyogrio": {"exporting"},
    "lxml": {"checking.checks", "crop_and_merge"},
    "distributed": {"batching"},
    "tomli": {"batching"},
    "pyproj": {"", "surface", "surface.grids", "opendrive.space"},
}


@cache
def modules() -> Mapping[str, ast.Module]:
    """Return the source of all modules by dotted name below the package; a package's ``__init__`` counts as it."""
    found = {}
    for path in sorted(SOURCE.rglob("*.py")):
        parts = path.relative_to(SOURCE).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = ast.parse(path.read_text("utf-8"))
    return found


def path_of(name: str) -> Path:
    folder = SOURCE.joinpath(*name.split("."))
    return folder / "__init__.py" if folder.is_dir() else folder.with_suffix(".py")


def is_package(name: str) -> bool:
    return path_of(name).name == "__init__.py"


def imported(name: str) -> Iterator[str]:
    """Every module, by full name, that one imports, in functions and for types too."""
    for node in ast.walk(modules()[name]):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{name}: relative import"
            assert node.module is not None
            for alias in node.names:
                inner = f"{node.module}.{alias.name}".removeprefix("osm2xodr.")
                yield f"osm2xodr.{inner}" if inner in modules() else node.module


def own_imports(name: str) -> set[str]:
    """Names below the package of the own modules that one imports."""
    return {item.removeprefix("osm2xodr.") for item in imported(name) if item.startswith("osm2xodr.")}


def parted(one: str, other: str) -> tuple[str, str, str]:
    """Return the innermost folder that holds both modules, and the next part of either's name ("" for its face)."""
    a, b = one.split("."), other.split(".")
    n = next((k for k, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))
    return ".".join(a[:n]), a[n] if n < len(a) else "", b[n] if n < len(b) else ""


def circle(graph: Mapping[str, Iterable[str]]) -> list[str]:
    """Return nodes that lead to each other in a circle, or none."""
    done: set[str] = set()

    def visit(name: str, trail: list[str]) -> list[str]:
        if name in trail:
            return [*trail[trail.index(name) :], name]
        if name not in done:
            for item in sorted(graph.get(name, ())):
                if found := visit(item, [*trail, name]):
                    return found
            done.add(name)
        return []

    return next((found for name in sorted(graph) if (found := visit(name, []))), [])


def test_the_stages_have_their_names() -> None:
    assert all(is_package(name) for name in STAGES)
    parts = {part for name in modules() for part in name.split(".")}
    assert sorted(part for part in parts if part != part.lower()) == ["osmParsing", "xodrWriter"]


def test_folders_can_be_taken_in_at_a_glance() -> None:
    for folder in [SOURCE, *(path for path in SOURCE.rglob("*") if path.is_dir())]:
        files = [path for path in folder.glob("*.py") if path.name != "__init__.py"]
        assert len(files) <= (6 if folder == SOURCE else 19), folder


def test_modules_are_short() -> None:
    lines = {name: len(path_of(name).read_text("utf-8").splitlines()) for name in modules()}
    assert {name: count for name, count in lines.items() if count > 600} == {}


def test_only_faces_are_imported() -> None:
    wrong = []
    for name in modules():
        for item in own_imports(name):
            folder, _, rest = parted(name, item)
            # Compiled loops call each other in C, past faces.
            in_c = all(path_of(one).with_suffix(".pxd").exists() for one in (name, item))
            if rest and item != f"{folder}.{rest}".removeprefix(".") and not in_c:
                wrong.append(f"{name} imports {item}")
    assert wrong == []


def test_nothing_imports_in_a_circle() -> None:
    assert circle({name: own_imports(name) - {name} for name in modules()}) == []


def test_folders_import_one_way() -> None:
    graphs: dict[str, dict[str, set[str]]] = {}
    for name in modules():
        for item in own_imports(name):
            folder, one, other = parted(name, item)
            if one and other:
                graphs.setdefault(folder, {}).setdefault(one, set()).add(other)
    assert len(graphs) > 10
    assert {folder: found for folder, graph in graphs.items() if (found := circle(graph))} == {}


def reached_from(part: str) -> set[str]:
    """Return the packages and modules at the top that one imports, directly or not."""
    top: dict[str, set[str]] = {}
    for name in modules():
        top.setdefault(name.split(".")[0], set()).update(item.split(".")[0] for item in own_imports(name))
    reached, todo = set[str](), [part]
    while todo:
        found = top.get(todo.pop(), set()) - reached
        reached |= found
        todo += sorted(found)
    return reached


def test_no_stage_knows_another_one() -> None:
    for stage in sorted(STAGES):
        reached = reached_from(stage)
        assert reached & STAGES <= {stage}, stage
        assert {"pipeline", "cli"}.isdisjoint(reached)


def test_the_conversion_knows_its_stages_alone() -> None:
    reached = reached_from("pipeline")
    assert reached > STAGES - {"xodrWriter"}
    around = {
        "batching",
        "checking",
        "cli",
        "exporting",
        "fetching",
        "crop_and_merge",
        "python_api",
        "starting",
        "viewing",
    }
    assert reached & around == set()


def test_only_the_command_line_names_modules_in_text() -> None:
    """The tests above do not see what is loaded or started by its name. Packages name themselves for their data."""
    named = [
        (name, node.value.removeprefix("osm2xodr."))
        for name, module in modules().items()
        for node in ast.walk(module)
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith("osm2xodr.")
    ]
    assert len(named) > 10
    assert [item for item in named if item[1] in modules() and not item[0].startswith((item[1], "cli."))] == []


def test_heights_know_no_other_wing() -> None:
    inside = {name for name in modules() if name.startswith("geometry.heights")}
    found = {item for name in inside for item in own_imports(name) if item.startswith("geometry")}
    assert {item for item in found if not item.startswith("geometry.heights")} <= {
        "geometry.defaults",
        "geometry.options",
    }


def test_libraries_stay_where_they_belong() -> None:
    for name in modules():
        folder = name if is_package(name) else name.rpartition(".")[0]
        for library in {item.split(".")[0] for item in imported(name)} & HOMES.keys():
            assert folder in HOMES[library], f"{name} imports {library}"


def test_no_name_of_a_number_has_two_values() -> None:
    values: dict[str, set[str]] = {}
    for node in (node for module in modules().values() for node in module.body if isinstance(node, ast.AnnAssign)):
        name, value = ast.unparse(node.target), ast.unparse(node.value) if node.value else ""
        if name.isupper() and not name.startswith("_") and re.search(r"\d", value):
            values.setdefault(name, set()).add(value)
    assert len(values) > 100
    assert {name: found for name, found in values.items() if len(found) > 1} == {}


def test_modules_say_what_they_are() -> None:
    docstrings = {name: ast.get_docstring(module) or "" for name, module in modules().items()}
    assert [name for name, text in docstrings.items() if len(text) <= 10] == []


def test_nobody_prints_but_the_command_line() -> None:
    for name, module in modules().items():
        calls = [node.func for node in ast.walk(module) if isinstance(node, ast.Call)]
        assert [call for call in calls if isinstance(call, ast.Name) and call.id == "print"] == [], name


def test_nobody_swallows_exceptions() -> None:
    for name, module in modules().items():
        handlers = [node for node in ast.walk(module) if isinstance(node, ast.ExceptHandler)]
        assert all(handler.type is not None for handler in handlers), f"{name}: bare except"


def test_the_version_stands_in_one_place() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert 'dynamic = ["version", ' in project
    assert re.findall(r'^path = "(.+)"$', project, re.MULTILINE) == ["src/osm2xodr/__init__.py"]
    number = f'"{osm2xodr.__version__}"'
    assert number not in project
    assert [name for name in modules() if number in path_of(name).read_text("utf-8")] == [""]


def test_runtime_dependencies_are_those_that_are_imported() -> None:
    required = importlib.metadata.requires("osm2xodr") or []
    declared = {re.split(r"[^\w-]", item)[0] for item in required if "extra ==" not in item}
    # What an option needs that not everybody uses.
    optional = {"distributed", "geopandas", "networkx", "pyogrio"}
    extra = {re.split(r"[^\w-]", item)[0] for item in required if re.search(r"extra == .(batch|geo).", item)}
    assert optional == extra
    # Where what is imported has another name than what is installed.
    named = {"PIL": "pillow"}
    libraries = {item.split(".")[0] for name in modules() for item in imported(name)}
    used = {named.get(library, library) for library in libraries}
    # Of type checkers, and of later Pythons.
    used -= {"osm2xodr", "typing_extensions", "tomllib", "compression"}
    assert used - sys.stdlib_module_names == declared | optional


def test_no_paths_of_one_machine() -> None:
    documents = [path for path in ROOT.iterdir() if path.is_file() and path.name != ".git"] + [ROOT / ".ci" / "run"]
    for path in [*map(path_of, modules()), *documents]:
        text = path.read_text(encoding="utf-8")
        assert re.findall(r"(?<![\w.>])/(?:home|root|work|opt|tmp|var|mnt|Users)/", text) == [], path


# Words that had meanings of their own here, for which engineers have others: an offset, not something aside.
PRIVATE_WORDS = set(
    [
        "abreast",
        "anew",
        "aside",
        "askew",
        "blunt",
        "drowned",
        "kin",
        "lain",
        "lest",
        "manieth",
        "mates",
        "mouth",
        "mouths",
        "owed",
        "said",
        "says",
        "stray",
        "sunk",
        "swung",
        "told",
    ]
)


def test_identifiers_are_plain_words() -> None:
    """`curves` and `geometry` still have some."""
    found = set()
    for name, module in modules().items():
        if name.startswith(("curves", "geometry")):
            continue
        for node in ast.walk(module):
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                found.add(node.name)
            elif isinstance(node, ast.arg):
                found.add(node.arg)
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                found.add(node.id)
    assert len(found) > 5000
    private = {
        name for name in found if PRIVATE_WORDS & {word.lower() for word in re.findall("[A-Z]?[a-z]+|[A-Z]+", name)}
    }
    # A field of streets, which `geometry` fills.
    assert private == {"moved_aside"}


def test_each_test_stands_where_what_it_tests_does() -> None:
    """A folder of tests is one of the source, or says what else it is for."""
    tests = ROOT / "tests"
    others = {"readers", "scenes", "support", "whole"}
    folders = {path.parent.relative_to(tests) for path in tests.rglob("test_*.py")} - {Path()}
    missing = [path for path in folders if path.parts[0] not in others and not (SOURCE / path).is_dir()]
    assert missing == []
