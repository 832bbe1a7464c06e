"""What is imported when: most of the time of a small conversion goes into imports."""

from __future__ import annotations

import pydoc
import subprocess
import sys
from pathlib import Path

import pytest
from small_area import write_area, write_dem

import osm2xodr

# Readers and projections, and parts of SciPy that take a tenth of a second and more with all that they import.
READERS = {"osmium", "rasterio", "pyproj"}
HEAVY = {
    "scipy.interpolate",
    "scipy.optimize",
    "scipy.spatial",
    "scipy.special",
    "scipy.fft",
    "scipy.stats",
    "scipy.signal",
    "scipy.integrate",
    "scipy.ndimage",
    "lxml",
}
# Chains of the standard library that nothing of a conversion needs, unless these libraries do.
NEEDLESS = {"importlib.metadata", "email", "http", "ssl", "uuid", "xml.sax", "unittest", "asyncio", "pydoc"}
# What this conversion was not asked for: copies of the process, cropping, a page.
UNASKED = {"multiprocessing", "xml.sax", "osm2xodr.python_api.files"}
OTHER_WINGS = tuple(
    f"osm2xodr.{wing}" for wing in ("batching", "checking", "exporting", "fetching", "crop_and_merge", "viewing")
)
LIBRARIES = "import numpy, scipy.sparse, scipy.sparse.linalg"


def loaded(code: str) -> set[str]:
    """Return the modules that are loaded when a program ends."""
    code = f"{code}\nimport sys\nprint('LOADED', *sorted(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.partition("LOADED ")[2].split())


def converted(*arguments: object) -> set[str]:
    words = ["convert", *map(str, arguments), "--overwrite", "-q"]
    return loaded(f"from osm2xodr.cli import main\nassert main({words!r}) == 0")


def test_the_pipeline_loads_no_reader() -> None:
    found = loaded("import osm2xodr.pipeline, osm2xodr.xodrWriter.document")
    assert {"numpy", "scipy.sparse", "osm2xodr.geometry.roads"} <= found
    assert found & (READERS | HEAVY) == set()
    assert (found & NEEDLESS) - loaded(LIBRARIES) == set()
    of_surface = {name.rpartition(".")[2] for name in found if name.startswith("osm2xodr.surface.")}
    assert of_surface == {"flat_surface", "options"}


@pytest.mark.parametrize("with_dem", [False, True])
def test_a_conversion_loads_what_it_needs(tmp_path: Path, with_dem: bool) -> None:
    area = write_area(tmp_path)
    dem = ["--dem", write_dem(tmp_path)] if with_dem else []
    found = converted(area, *dem, "-o", tmp_path / "area.xodr")
    assert found & READERS == {"osmium", "pyproj", *(["rasterio"] if with_dem else [])}
    # The surface's splines are SciPy's.
    assert with_dem or found & HEAVY == set()
    assert ("osm2xodr.surface.grids.raster_file" in found) is with_dem
    assert found & UNASKED == set()
    assert {name for name in found if name.startswith(OTHER_WINGS)} == set()


def test_reading_a_file_loads_no_scipy(tmp_path: Path) -> None:
    file = tmp_path / "area.xodr"
    converted(write_area(tmp_path), "-o", file)
    found = loaded(f"from osm2xodr.cli import main\nassert main(['check', {str(file)!r}]) == 0")
    assert {"numpy", "lxml"} <= found
    assert {name for name in found if name.split(".")[0] == "scipy"} == set()


def test_the_library_loads_when_it_is_used() -> None:
    found = loaded("import osm2xodr")
    assert {name for name in found if name.startswith("osm2xodr.")} == {"osm2xodr.system", "osm2xodr.system.lazy"}
    assert found & (READERS | HEAVY | NEEDLESS | {"numpy", "click"}) == set()


def test_help_shows_what_the_library_has() -> None:
    text = pydoc.plain(pydoc.render_doc(osm2xodr))
    for line in ("convert(area: 'str | os.PathLike[str]', ", "check(file: ", "class Locator(", "class Conversion("):
        assert f"\n    {line}" in text
    assert "Turn an OpenStreetMap file and elevation models into an OpenDRIVE road network." in text
    namespace: dict[str, object] = {}
    exec("from osm2xodr import *", namespace)
    assert set(osm2xodr.__all__) <= namespace.keys()  # type: ignore[attr-defined]


def test_the_library_has_what_it_says() -> None:
    names = [name for name in dir(osm2xodr) if not name.startswith("_")]
    assert {"convert", "read", "check", "report", "render", "export", "Locator", "Conversion"} <= set(names)
    for name in names:
        assert getattr(osm2xodr, name).__doc__, name
    with pytest.raises(AttributeError, match="no attribute 'konvert'"):
        getattr(osm2xodr, "konvert")  # noqa: B009 - what type checkers refuse
