"""The rules that keep the parts apart, read from the source itself."""

from __future__ import annotations

import ast
import importlib.metadata
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import osm2xodr

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "osm2xodr"
MODULES = sorted(SOURCE.rglob("*.py"))
STAGES = ("osmParsing", "surface", "geometry", "furniture", "xodrWriter")

# What the stages share, and what may use them.
SHARED = {
    "model",
    "diagnostics",
    "elevation_report",
    "errors",
    "defaults",
    "projection",
    "parallel",
    "opendrive",
    "memory",
    "curves",
    "grouping",
    "outlines",
    "curve_finder",
    "conflicts",
    "countries",
    "targets",
    "street_signs",
}
# Packages that work on files of OpenDRIVE; they stand on the stages, never the other way round.
TOOLS = ("xodr_reader", "road_space", "exporting", "checking", "viewing", "batch")
OUTSIDE = {
    *TOOLS,
    "cli",
    "cli_batch",
    "cli_batch_options",
    "cli_check",
    "cli_common",
    "cli_convert",
    "cli_convert_options",
    "cli_export",
    "cli_locate",
    "cli_render",
    "cli_report",
    "cli_surface",
    "locating",
    "partition_file",
    "pipeline",
    "delivery",
    "limits",
    "report",
    "standard_streams",
    "statistics",
    "street_points",
    "surface_pictures",
    "surface_report",
    "__main__",
}

# Libraries that only these modules may import.
RESERVED = {
    "click": {
        "cli",
        "cli_batch",
        "cli_batch_options",
        "cli_check",
        "cli_common",
        "cli_convert",
        "cli_convert_options",
        "cli_export",
        "cli_locate",
        "cli_render",
        "cli_report",
        "cli_surface",
    },
    "PIL": {"viewing.png"},
    "osmium": {"osmParsing.reader", "batch.cut_source", "batch.cut_writing"},
    "rasterio": {"surface.dem"},
    "lxml": set[str](),
    "dask": {"batch.running"},
    "distributed": {"batch.running"},
    "psutil": {"batch.running"},
    "tomli": {"batch.manifest"},
    "pyproj": {"projection", "surface", "road_space.georeference"},
}


def name_of(path: Path) -> str:
    """Dotted name below the package, such as ``geometry.roads``; a package's ``__init__`` counts as the package."""
    parts = path.relative_to(SOURCE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" and len(parts) > 1 else parts)


def imports(path: Path) -> Iterator[str]:
    """Every module that a source file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            assert node.module is not None
            yield node.module
            if node.module == "osm2xodr":
                yield from (f"osm2xodr.{alias.name}" for alias in node.names)


def own_imports(path: Path) -> set[str]:
    """Names below the package that a module imports."""
    return {item.removeprefix("osm2xodr.") for item in imports(path) if item.startswith("osm2xodr.")}


@pytest.fixture(params=MODULES, ids=name_of)
def module(request: pytest.FixtureRequest) -> Path:
    path = request.param
    assert isinstance(path, Path)
    return path


def test_the_four_stages_are_there() -> None:
    packages = {path.name for path in SOURCE.iterdir() if (path / "__init__.py").exists()}
    assert packages >= set(STAGES)
    assert packages <= {*STAGES, *TOOLS, "model"}
    names = {part for path in MODULES for part in path.relative_to(SOURCE).with_suffix("").parts}
    assert sorted(name for name in names if name != name.lower()) == ["osmParsing", "xodrWriter"]


def test_stages_know_what_they_share_and_nothing_else(module: Path) -> None:
    name = name_of(module)
    stage = name.split(".")[0]
    for item in own_imports(module) - {"__version__"}:
        first = item.split(".")[0]
        if stage in STAGES:
            assert first in SHARED | {stage}, f"{name} imports {item}"
        elif name in SHARED:
            assert first in SHARED, f"{name} imports {item}"
        else:
            assert first in SHARED | OUTSIDE | set(STAGES), f"{name} imports {item}"


def test_every_module_has_a_place(module: Path) -> None:
    first = name_of(module).split(".")[0]
    assert first in {*STAGES, *SHARED, *OUTSIDE, "__init__"}


def test_libraries_stay_where_they_belong(module: Path) -> None:
    name = name_of(module)
    for item in imports(module):
        library = item.split(".")[0]
        if library in RESERVED:
            assert {name, name.split(".")[0]} & RESERVED[library], f"{name} imports {library}"


def test_no_imports_in_circles() -> None:
    """Read top-level imports only: those in functions run later and may close a circle."""
    graph: dict[str, set[str]] = {}
    names = {name_of(path) for path in MODULES}
    for path in MODULES:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        found = {node.module for node in tree.body if isinstance(node, ast.ImportFrom) and node.module}
        targets = {item.removeprefix("osm2xodr.") for item in found if item.startswith("osm2xodr.")}
        graph[name_of(path)] = (targets & names) - {name_of(path)}
    done: set[str] = set()

    def visit(name: str, trail: tuple[str, ...]) -> None:
        assert name not in trail, f"circle: {' -> '.join((*trail, name))}"
        if name not in done:
            for item in sorted(graph[name]):
                visit(item, (*trail, name))
            done.add(name)

    for name in sorted(graph):
        visit(name, ())


def test_modules_are_short(module: Path) -> None:
    # The model and the table of defaults are documentation for the most part, and better read in one piece.
    limit = {"defaults": 1200, "opendrive": 500}.get(name_of(module), 400)
    assert len(module.read_text(encoding="utf-8").splitlines()) <= limit


def test_modules_say_what_they_are(module: Path) -> None:
    docstring = ast.get_docstring(ast.parse(module.read_text(encoding="utf-8")))
    assert docstring is not None
    assert len(docstring) > 10


def test_nobody_prints_but_the_command_line(module: Path) -> None:
    calls = [
        node
        for node in ast.walk(ast.parse(module.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
    ]
    assert calls == []


def test_nobody_swallows_exceptions(module: Path) -> None:
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ExceptHandler):
            assert node.type is not None, f"{module}:{node.lineno}: bare except"


def test_the_version_stands_in_one_place() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert 'dynamic = ["version"]' in project
    assert re.findall(r'^path = "(.+)"$', project, re.MULTILINE) == ["src/osm2xodr/__init__.py"]
    number = f'"{osm2xodr.__version__}"'
    assert number not in project
    assert [path for path in MODULES if number in path.read_text(encoding="utf-8")] == [SOURCE / "__init__.py"]


def test_runtime_dependencies_are_those_that_are_imported() -> None:
    required = importlib.metadata.requires("osm2xodr") or []
    declared = {re.split(r"[^\w-]", item)[0] for item in required if "extra ==" not in item}
    # What a command needs that not everybody uses; the first brings the last two along.
    optional = {"distributed", "tomli", "dask", "psutil"}
    extra = {re.split(r"[^\w-]", item)[0] for item in required if re.search(r"extra == .batch.", item)}
    assert optional - {"dask", "psutil"} <= extra
    # Where what is imported has another name than what is installed.
    named = {"PIL": "pillow"}
    used = {named.get(item.split(".")[0], item.split(".")[0]) for path in MODULES for item in imports(path)}
    assert used - {"osm2xodr"} - sys.stdlib_module_names - {"tomllib"} == declared | optional


def test_no_paths_of_one_machine() -> None:
    documents = [path for path in ROOT.iterdir() if path.is_file()] + [ROOT / ".ci" / "run"]
    for path in [*MODULES, *documents]:
        text = path.read_text(encoding="utf-8")
        assert re.findall(r"(?<![\w.>])/(?:home|root|work|opt|tmp|var|mnt|Users)/", text) == [], path
