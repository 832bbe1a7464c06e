"""

Small pictures of road networks.
"""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import rasterio
from PIL import Image

from osm2xodr.errors import InputError
from osm2xodr.viewing import draw_thumbnail
from osm2xodr.viewing.picture.drawing import as_png

ROADS = """<OpenDRIVE>
 <road name="a &lt;planView&gt;" length="200" id="1" junction="-1">
  <planView>
   <geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry>
   <geometry s="100" x="100" y="0" hdg="1.5707963268" length="1e2"><line/></geometry>
  </planView>
  <elevationProfile/>
 </road>
 <road name="b" length="10" id="2" junction="7">
  <planView>
   <geometry s="0" x="0" y="100" hdg="-1.5707963268" length="50"><line/></geometry>
  </planView>
 </road>
</OpenDRIVE>
"""


def test_png_is_read_back_as_it_was(tmp_path: Path) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (17, 23, 3), np.uint8)
    path = tmp_path / "a.png"
    path.write_bytes(as_png(pixels))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)
        with rasterio.open(path) as dataset:
            assert np.array_equal(dataset.read(), pixels.transpose(2, 0, 1))
    assert as_png(pixels) == as_png(pixels)


def pixels(data: bytes) -> npt.NDArray[np.uint8]:
    return np.asarray(Image.open(io.BytesIO(data)).convert("L"))


def test_roads_lie_where_they_should(tmp_path: Path) -> None:
    path = tmp_path / "a.xodr"
    path.write_text(ROADS, encoding="utf-8")
    data = draw_thumbnail(path)
    assert data == draw_thumbnail(path)
    found = pixels(data) < 160
    rows, columns = np.nonzero(found)
    side = len(found)
    low, high = rows.min(), columns.max()
    # A line along the bottom, one up the right side, and half of one down the left side.
    assert found[rows.max() - 1 : rows.max() + 1].any(axis=0).sum() > 0.85 * side
    assert found[:, high - 1 : high + 1].any(axis=1).sum() > 0.85 * side
    left = found[: side // 2 - 4, : side // 4].any(axis=1).sum()
    assert 0.3 * side < left <= 0.5 * side
    assert not found[side // 2 + 4 : side - 8, : side // 4].any()
    assert low < 0.1 * side
    assert len(data) < 1000


@pytest.mark.parametrize("text", ["", "<OpenDRIVE/>"])
def test_a_file_without_roads_has_none(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.xodr"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"a\.xodr has no roads that can be drawn"):
        draw_thumbnail(path)
    with pytest.raises(InputError, match=r"none\.xodr cannot be read: no such file"):
        draw_thumbnail(tmp_path / "none.xodr")
