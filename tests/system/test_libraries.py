"""GDAL as rasterio brings it.

Linear algebra on one thread, and all of them afterwards.
"""

from __future__ import annotations

import _ctypes
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import rasterio

from osm2xodr.errors import Osm2xodrError
from osm2xodr.system import libraries

CODE = """
import numpy as np, scipy.sparse.linalg
from osm2xodr.system import one_thread
from osm2xodr.system.libraries import _limit

def many() -> int:
    "Count the libraries that use more than one thread."
    undo = _limit()
    for call in undo:
        call()
    return len(undo)

one, other = np.random.default_rng(1).normal(size=(2, 100_000))
before = many()
with one_thread():
    with one_thread():
        pass
    print(float(one @ other).hex(), many())
print(before - many())
"""


def test_gdal_is_found_beside_rasterio_where_a_module_gives_its_own_names_alone(tmp_path: Path) -> None:
    # As on Windows: a module without GDAL's names, and GDAL in a folder beside the package.
    installed = SimpleNamespace(
        __file__=str(tmp_path / "rasterio" / "__init__.py"), _env=SimpleNamespace(__file__=_ctypes.__file__)
    )
    with pytest.raises(Osm2xodrError, match=r"^GDAL is not found in this installation of rasterio, .* with pip$"):
        libraries._library(installed)
    (tmp_path / "rasterio.libs").mkdir()
    (tmp_path / "rasterio.libs" / "gdal-1a2b.dll").symlink_to(rasterio._env.__file__)
    with rasterio.Env() as environment:
        assert libraries._library(installed).GDALGetDriverCount() >= len(environment.drivers()) > 0


def run(threads: str) -> list[str]:
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": threads}
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True, env=environment)
    return done.stdout.splitlines()


def test_sums_are_those_of_one_thread_and_threads_come_back() -> None:
    one, many = run("1"), run("4")
    assert one == many
    assert one[0].endswith(" 0")
    assert one[1] == "0"
