"""Files that would take the square of their roads to compare."""

from __future__ import annotations

from pathlib import Path

import pytest
from xodr_text import document, lane, read_text, road, section

from osm2xodr.errors import InputError
from osm2xodr.opendrive import refuse_crowds

LANE = section(0.0, right=lane(-1, (0, 3.5)))


def test_roads_on_each_other_by_the_hundred_are_refused(tmp_path: Path) -> None:
    copies = [road(str(k), lanes=LANE) for k in range(300)]
    near = [text.replace('x="0.0"', f'x="{k * 1e-3}"') for k, text in enumerate(copies)]
    file = read_text(tmp_path, document(*near))
    with pytest.raises(InputError, match=r"too many roads lie on each other .* at road '\d+', s = \d+ m; look"):
        refuse_crowds(file)
    # As many side by side are a large car park.
    apart = [text.replace('y="0.0"', f'y="{k * 3.5}"') for k, text in enumerate(copies)]
    refuse_crowds(read_text(tmp_path, document(*apart)))


def test_larger_areas_than_any_road_covers_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from osm2xodr.opendrive.space import crowds

    monkeypatch.setattr(crowds, "_CELLS", 10.0)
    monkeypatch.setattr(crowds, "_CELLS_EACH", 1.0)
    with pytest.raises(InputError, match=r"roads cover too large an area to compare them, most at road '1'"):
        refuse_crowds(read_text(tmp_path, document(road(lanes=LANE))))
