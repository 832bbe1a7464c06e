"""Where elements are, by their nodes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from osm_builder import write_osm

from osm2xodr.osmParsing.file.reader import element_places
from osm2xodr.projection import make_frame, to_geographic

FRAME = make_frame(42.5, 1.5)
XY = {1: (0.0, 0.0), 2: (30.0, 0.0), 3: (30.0, 40.0), -4: (-50.0, -60.0)}


@pytest.fixture
def area(tmp_path: Path) -> Path:
    lon, lat = to_geographic(FRAME, *np.array(list(XY.values())).T)
    nodes = [
        f'<node id="{number}" version="1" lat="{y:.9f}" lon="{x:.9f}"/>'
        for number, x, y in zip(XY, lon.tolist(), lat.tolist(), strict=True)
    ]
    ways = [
        '<way id="10" version="1"><nd ref="1"/><nd ref="2"/></way>',
        '<way id="11" version="1"><nd ref="3"/><nd ref="99"/></way>',
        '<way id="12" version="1"><nd ref="99"/></way>',
    ]
    relation = (
        '<relation id="20" version="1"><member type="way" ref="11" role="from"/>'
        '<member type="way" ref="77" role="to"/><member type="node" ref="2" role="via"/></relation>'
    )
    return write_osm(tmp_path, [*nodes, *ways, relation])


def test_elements_are_where_their_nodes_are(area: Path) -> None:
    names = ["node/-4", "node/8", "way/10", "way/11", "way/12", "way/13", "relation/20", "relation/21"]
    found = element_places(area, FRAME, names)
    expected = {"node/-4": [-4], "way/10": [1, 2], "way/11": [3], "relation/20": [2, 3]}
    assert found.keys() == expected.keys()
    for name, nodes in expected.items():
        # OSM's degrees have seven digits.
        rounded = {(round(x, 1), round(y, 1)) for x, y in found[name].tolist()}
        assert rounded == {XY[node] for node in nodes}
        assert len(found[name]) == len(nodes)


def test_without_elements_nothing_is_read(area: Path) -> None:
    assert element_places(area, FRAME, []) == {}
    assert element_places(area, FRAME, ["way/12"]) == {}
