"""Where files are on Earth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from xodr_text import HEADER, PROJECTION, document, read_text, road

from osm2xodr.opendrive.space.georeference import frame_of
from osm2xodr.opendrive.tables import Header


def test_frames_turn_and_move_by_the_offset(tmp_path: Path) -> None:
    header = HEADER.replace("</header>", '<offset x="100" y="50" z="7" hdg="1.5707963267948966"/></header>')
    plain, _ = frame_of(read_text(tmp_path, document(road())).header)
    moved, _ = frame_of(read_text(tmp_path, document(road(), header=header)).header)
    assert plain is not None
    assert moved is not None
    x, y = np.array([10.0, -3.0]), np.array([20.0, 4.0])
    np.testing.assert_allclose(moved.to_geographic(x, y), plain.to_geographic(100.0 - y, 50.0 + x), atol=1e-12)
    np.testing.assert_allclose(moved.to_inertial(*moved.to_geographic(x, y)), [x, y], atol=1e-6)
    np.testing.assert_allclose(moved.height(np.array([1.0])), [8.0])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "no geoReference"),
        ("", "no geoReference"),
        ("nonsense", "cannot be used"),
        ("EPSG:4326", "not a projection"),
        (PROJECTION.replace("+units=m", "+units=us-ft"), "not in metres"),
    ],
)
def test_why_there_is_no_frame(text: str | None, words: str) -> None:
    frame, reason = frame_of(Header((1, 7), {}, text, None))
    assert frame is None
    assert words in reason


def test_georeferences_in_all_words() -> None:
    for text in ("EPSG:25832", "+proj=utm +zone=32 +ellps=GRS80 +units=m"):
        frame, _ = frame_of(Header((1, 7), {}, text, (0.0, 0.0, 0.0, 0.0)))
        assert frame is not None
        lon, lat = frame.to_geographic(np.array([500_000.0]), np.array([5_500_000.0]))
        assert lon[0] == pytest.approx(9.0, abs=1e-6)
        assert lat[0] == pytest.approx(49.6525, abs=1e-3)
