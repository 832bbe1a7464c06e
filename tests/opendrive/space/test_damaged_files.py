"""Whatever is wrong with a file: it is read, its roads are looked up and exported, or one sentence says why not."""

from __future__ import annotations

import io
import json
import re

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from xodr_text import cubics, document, geometry, lane, read_text, road, section

from osm2xodr.errors import InputError
from osm2xodr.exporting import road_mesh, write_geojson, write_glb
from osm2xodr.opendrive.locating import Locator

PLAN = "".join(
    [
        geometry('<spiral curvStart="-0.02" curvEnd="0.06"/>', 30.0),
        geometry('<poly3 a="0" b="0" c="0.005" d="-0.0001"/>', 30.0, 30.0),
        geometry(
            '<paramPoly3 aU="0" bU="40" cU="0" dU="0" aV="0" bV="0" cV="6" dV="0" pRange="normalized"/>', 40.5, 60.0
        ),
        geometry('<arc curvature="0.02"/>', 10.0, 100.5),
    ]
)
WALK = lane(-2, (0, 1.5), kind="sidewalk", more='<height sOffset="0" inner="0.1" outer="0.2"/>')
LANES = (
    cubics("laneOffset", (0, 0.4, 0.01))
    + section(0.0, lane(1, (0, 3.0, 0.0, 0.002)), lane(-1, (0, 3.5)) + WALK)
    + section(50.0, lane(1, (0, 6.0), border=True), lane(-1, (0, 1.0)))
)
FURNITURE = (
    '<objects><object id="c" type="crosswalk" s="10" t="0" hdg="0"><outline><cornerLocal u="-1" v="-3" z="0"/>'
    '<cornerLocal u="-1" v="3" z="0"/><cornerLocal u="1" v="3" z="0"/></outline></object></objects>'
    '<signals><signal id="x" s="30" t="-6" zOffset="3"/></signals>'
)
SOUND = document(
    road(
        "1",
        PLAN,
        110.5,
        lanes=LANES,
        more=FURNITURE,
        elevation=cubics("elevation", (0, 1.0, 0.1), (20, 3.0)),
        lateral=cubics("superelevation", (0, 0.1)),
    ),
    road("2", junction="9"),
    '<junction id="9"><connection id="0" incomingRoad="1" connectingRoad="2" contactPoint="start"/></junction>',
)
_BEGIN = SOUND.index("<road")
_VALUES = [match.span(1) for match in re.finditer(r'="([^"]*)"', SOUND) if match.start() > _BEGIN]
_ELEMENTS = [match.span() for match in re.finditer(r"<(?!/)[^<>]*/>", SOUND) if match.start() > _BEGIN]
_BAD = ["", "x", "nan", "-1", "0", "1e300", "1e11", "-1e6", "5e-324", "-0.5"]


def try_everything(folder: pytest.TempPathFactory, text: str) -> None:
    try:
        file = read_text(folder.mktemp("damaged"), text)
    except InputError as error:
        assert "a sound file can have" in str(error)  # noqa: PT017 - most damage can be read
        return
    locator = Locator(file)
    places = locator.at_inertial(np.array([10.0, 50.0, 1e7]), np.array([2.0, -3.0, -1e7]))
    assert len(locator.describe(places)) == len(places.s)
    stream = io.BytesIO()
    write_geojson(file, stream, 0.05, 10.0)
    assert json.loads(stream.getvalue())["type"] == "FeatureCollection"
    try:
        mesh = road_mesh(file, 0.05, 10.0)
    except InputError as error:
        assert "no lane with a surface" in str(error)  # noqa: PT017 - most damage leaves a surface
        return
    write_glb(mesh, file.header, stream, "0")
    assert np.isfinite(mesh.vertices).all()


@settings(max_examples=40)
@given(
    st.lists(
        st.tuples(st.sampled_from(_VALUES), st.sampled_from(_BAD)),
        min_size=1,
        max_size=3,
        unique_by=lambda change: change[0],
    )
)
def test_values(tmp_path_factory: pytest.TempPathFactory, changes: list[tuple[tuple[int, int], str]]) -> None:
    text = SOUND
    for (first, last), value in sorted(changes, reverse=True):
        text = text[:first] + value + text[last:]
    try_everything(tmp_path_factory, text)


@settings(max_examples=25)
@given(st.sampled_from(_ELEMENTS), st.booleans())
def test_elements(tmp_path_factory: pytest.TempPathFactory, span: tuple[int, int], twice: bool) -> None:
    first, last = span
    try_everything(tmp_path_factory, SOUND[:last] + SOUND[first:] if twice else SOUND[:first] + SOUND[last:])
