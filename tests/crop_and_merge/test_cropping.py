"""Parts of networks: the same roads where they are kept, links that lead somewhere, everything else as it was."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from xodr_text import cubics, document, geometry, lane, read_text, road, section

from osm2xodr.crop_and_merge import Choice, Stretch, choose_inside, choose_roads, crop_network, write_tree
from osm2xodr.crop_and_merge.cropping import Inside
from osm2xodr.errors import EmptyAreaError
from osm2xodr.model import BoolArray, FloatArray
from osm2xodr.opendrive import lane_borders, pose, read_xodr, section_at, surface_points
from osm2xodr.opendrive.tables import ABSENT, OpenDrive

JUNCTION_LINK = '<{} elementType="junction" elementId="9"/>'
ROAD_LINK = '<{} elementType="road" elementId="{}" contactPoint="{}"/>'


def cropped(file: OpenDrive, choice: Choice, folder: Path) -> tuple[OpenDrive, list[str]]:
    root, lost = crop_network(file, choice)
    stream = io.BytesIO()
    write_tree(root, stream)
    path = folder / "part.xodr"
    path.write_bytes(stream.getvalue())
    return read_xodr(path), lost


def curved(folder: Path) -> OpenDrive:
    """Return a road of all kinds of records: line, spiral, arc, cubic."""
    plan = (
        geometry("<line/>", 30.0, x=5.0, hdg=0.3)
        + geometry('<spiral curvStart="0" curvEnd="0.02"/>', 30.0, 30.0, 33.66, 8.866, 0.3)
        + geometry('<arc curvature="0.02"/>', 30.0, 60.0, 60.0, 20.0, 0.6)
        + geometry(
            '<paramPoly3 aU="0" bU="1" cU="0" dU="0" aV="0" bV="0" cV="0.01" dV="0" pRange="arcLength"/>',
            10.0, 90.0, 80.0, 40.0, 1.2,
        )
    )  # fmt: skip
    lanes = (
        cubics("laneOffset", (0, 0.5, 0.01), (50, 1.0, 0.0, 1e-3))
        + section(0.0, lane(1, (0, 3.0)), lane(-1, (0, 3.0, 0.02), (20, 3.4, 0.0, 1e-3)) + lane(-2, (0, 2.0)))
        + section(45.0, lane(1, (0, 3.0)), lane(-1, (0, 3.5), (30, 3.5, 0.01)))
    )
    return read_text(
        folder,
        document(
            road(
                "1", plan, lanes=lanes,
                elevation=cubics("elevation", (0, 5.0, 0.05), (40, 7.0, 0.05, -1e-3, 1e-5)),
                lateral=cubics("superelevation", (0, 0.01, 1e-3)),
            )
        ),
    )  # fmt: skip


@pytest.mark.parametrize(("begin", "end"), [(0, 41), (17, 83), (41, 100), (62, 90), (33, 39), (45, 60)])
def test_a_stretch_lies_where_it_lay(tmp_path: Path, begin: float, end: float) -> None:
    whole = curved(tmp_path)
    part, lost = cropped(whole, Choice((Stretch(0, begin, end, begin == 0, end == 100),), frozenset()), tmp_path)
    assert lost == ["1 end of a road was cut off"]
    assert part.roads.length[0] == end - begin
    assert part.misfits == whole.misfits
    s = np.linspace(0.001, end - begin - 0.001, 57)
    road_ = np.zeros(57, np.int64)
    for one, other in zip(pose(part, road_, s), pose(whole, road_, s + begin), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-7)
    rows = section_at(part, road_, s), section_at(whole, road_, s + begin)
    for number in (1, -1):
        lanes = [
            np.array([np.flatnonzero((file.lanes.section == k) & (file.lanes.id == number))[0] for k in row])
            for file, row in zip((part, whole), rows, strict=True)
        ]
        borders = lane_borders(part, lanes[0], s), lane_borders(whole, lanes[1], s + begin)
        np.testing.assert_allclose(borders[0], borders[1], atol=1e-9)
        edge = surface_points(part, road_, s, borders[0][1]), surface_points(whole, road_, s + begin, borders[1][1])
        np.testing.assert_allclose(edge[0], edge[1], atol=1e-7)


def crossing(folder: Path) -> OpenDrive:
    """Return a junction at x = 100 with two arms of 100 m, west and east, and one connecting road between them."""
    signal = '<signal id="s{}" s="{}" t="-4" orientation="+" dynamic="yes" country="OpenDRIVE" type="1000001"/>'
    unknown = '<userData code="mine"><deep x="1"/></userData>'
    first = f"<signals>{signal.format(1, 20)}{signal.format(2, 95)}</signals>{unknown}"
    link = '<link><predecessor id="-1"/><successor id="-1"/></link>'
    text = document(
        road("1", link=JUNCTION_LINK.format("successor"), more=first),
        road(
            "2", geometry("<line/>", 10.0, x=100.0), 10.0, junction="9",
            link=ROAD_LINK.format("predecessor", 1, "end") + ROAD_LINK.format("successor", 3, "start"),
            lanes=section(0.0, right=lane(-1, (0, 3.5), more=link)),
        ),
        road("3", geometry("<line/>", 100.0, x=110.0), link=JUNCTION_LINK.format("predecessor")),
        '<controller id="c1"><control signalId="s1"/></controller>',
        '<controller id="c2"><control signalId="s2"/></controller>',
        '<junction id="9" name=""><connection id="0" incomingRoad="1" connectingRoad="2" contactPoint="start">'
        '<laneLink from="-1" to="-1"/></connection><controller id="c1"/><controller id="c2"/></junction>',
    )  # fmt: skip
    return read_text(folder, text)


def west_of(border: float) -> Inside:
    def inside(x: FloatArray, y: FloatArray) -> BoolArray:
        return x < border

    return inside


def test_a_junction_goes_with_the_ends_of_its_arms(tmp_path: Path) -> None:
    # The middle of the connecting road lies at x = 105.
    part, lost = cropped(crossing(tmp_path), choose_inside(crossing(tmp_path), west_of(106)), tmp_path)
    assert part.roads.id == ("1", "2", "3")
    assert part.roads.length.tolist() == [100, 10, 4]
    assert lost == ["1 end of a road was cut off"]
    assert part.roads.link[2].tolist() == [0, ABSENT]
    part, lost = cropped(crossing(tmp_path), choose_inside(crossing(tmp_path), west_of(104)), tmp_path)
    assert part.roads.id == ("1",)
    # The light at the end of the arm belongs to the junction, and so does its controller.
    assert part.roads.length.tolist() == [96]
    assert [item.attributes["id"] for item in part.furniture] == ["s1", "s2"]
    assert part.junctions.id == ()
    assert part.roads.link.tolist() == [[ABSENT, ABSENT]]
    assert lost == ["1 end of a road was cut off", "left out: 2 roads, 1 junction"]


def test_what_is_beyond_the_cut_is_dropped_with_what_refers_to_it(tmp_path: Path) -> None:
    part, lost = cropped(crossing(tmp_path), choose_inside(crossing(tmp_path), west_of(50)), tmp_path)
    assert [(item.attributes["id"], item.s) for item in part.furniture] == [("s1", 20)]
    assert [item.id for item in part.controllers] == ["c1"]
    assert lost[1] == "left out: 2 roads, 1 junction, 1 signal or object beyond cuts, 1 controller"
    root = etree.parse(str(tmp_path / "part.xodr")).getroot()
    assert root.find("road/userData[@code='mine']/deep").get("x") == "1"  # type: ignore[union-attr]


def test_a_road_that_comes_back_is_two_roads(tmp_path: Path) -> None:
    def outside(x: FloatArray, y: FloatArray) -> BoolArray:
        return np.asarray((x < 30) | (x > 70))

    tunnel = '<objects><tunnel id="7" s="10" length="80" type="standard"/></objects>'
    file = read_text(tmp_path, document(road("1", more=tunnel)))
    part, _ = cropped(file, choose_inside(file, outside), tmp_path)
    assert part.roads.id == ("1", "8")
    assert part.roads.length.tolist() == [30, 30]
    assert part.plan_view.x.tolist() == [0, 70]
    assert [(item.s, item.length) for item in part.furniture] == [(10, 20), (0, 20)]
    assert len({item.attributes["id"] for item in part.furniture}) == 2


def test_roads_by_id_are_whole(tmp_path: Path) -> None:
    file = crossing(tmp_path)
    part, _ = cropped(file, choose_roads(file, frozenset({"1", "3"})), tmp_path)
    assert part.roads.id == ("1", "2", "3")
    assert part.junctions.id == ("9",)
    part, lost = cropped(file, choose_roads(file, frozenset({"3"})), tmp_path)
    assert part.roads.id == ("3",)
    assert lost[0].startswith("left out: 2 roads, 1 junction")


def test_nothing_is_an_error(tmp_path: Path) -> None:
    file = crossing(tmp_path)
    with pytest.raises(EmptyAreaError, match="no road in this part"):
        crop_network(file, choose_inside(file, west_of(-5)))


def test_roads_that_lack_parts_do_no_harm(tmp_path: Path) -> None:
    link = JUNCTION_LINK.format("successor")
    file = read_text(
        tmp_path,
        document(
            road("1", ""), road("2", lanes=""), road("3", "", link=link, lanes=""), '<junction id="9" name=""/>'
        ),
    )  # fmt: skip
    part, _ = cropped(file, choose_inside(file, west_of(50)), tmp_path)
    assert part.roads.id == ("2",)
    (stretch,) = (Stretch(0, 10.0, 20.0, False, False),)
    part, _ = cropped(file, Choice((stretch,), frozenset()), tmp_path)
    assert part.roads.length.tolist() == [10]
