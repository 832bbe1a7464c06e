from __future__ import annotations

import tracemalloc
from pathlib import Path

from xodr_text import cubics, document, road

from osm2xodr.opendrive import read_xodr


def test_a_file_is_read_in_little_more_than_its_size(tmp_path: Path) -> None:
    """It was nearly three times as much, when numbers were kept as objects until they became tables."""
    path = tmp_path / "large.xodr"
    records = cubics("elevation", *((k / 7.0, k / 3.0, 1.0 / (k + 3.0), 1e-4 / (k + 7.0)) for k in range(500)))
    one = road(elevation=records)
    path.write_text(document(*(one.replace('id="1"', f'id="{k}"') for k in range(60))), encoding="utf-8")
    size = path.stat().st_size
    read_xodr(path)
    tracemalloc.start()
    try:
        file = read_xodr(path)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert len(file.elevation.s) == 30_000
    assert peak < 2.0 * size
