from pathlib import Path

import numpy as np
import pytest
from dem_factory import BAVARIA, around, read, write_raster

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.surface import suspect_feet

UTM = "EPSG:32632"


@pytest.mark.parametrize(
    ("height", "ele", "suspected"),
    [
        (984.3, [300.0, 301.0, 299.0, 305.0], True),
        (984.3, [300.0, 301.0, 984.0, 299.0], True),
        (300.0, [300.0, 301.0, 299.0, 305.0], False),
        (984.3, [300.0, 301.0], False),
        (33.0, [10.0, 10.0, 10.0, 10.0], False),
    ],
)
def test_models_in_feet_are_suspected(tmp_path: Path, height: float, ele: list[float], suspected: bool) -> None:
    transform, rows, cols = around(BAVARIA, UTM, 20.0)
    path = write_raster(tmp_path / "dem.tif", np.full((rows, cols), height, np.float32), transform, UTM)
    x = np.linspace(-400.0, 400.0, len(ele))
    surface, _ = read(path, BAVARIA, x, 0.0 * x)
    diagnostics = Diagnostics()
    suspect_feet([path], surface, x, 0.0 * x, np.array(ele), diagnostics)
    assert [item.code for item in diagnostics] == ["dem-unit"] * suspected
    assert all("say so with --dem-unit ft" in item.message for item in diagnostics)
