"""Files of one frame as one network: links where ends meet, ids that do not clash, nothing twice."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from scene_files import SMALL_SCENES, Conversions, Scene, scene_named
from xodr_text import document, geometry, lane, read_text, road, section

from osm2xodr.checking import driving_of
from osm2xodr.crop_and_merge import choose_inside, crop_network, merge_networks, write_tree
from osm2xodr.errors import InputError
from osm2xodr.model import BoolArray, FloatArray
from osm2xodr.opendrive import End, LinkKind, pose, read_xodr
from osm2xodr.opendrive.tables import OpenDrive

OTHER = '<header revMajor="1" revMinor="7"><geoReference>+proj=utm +zone=33 +datum=WGS84</geoReference></header>'


def file(folder: Path, name: str, *parts: str, **options: str) -> OpenDrive:
    (folder / name).mkdir(exist_ok=True)
    return read_text(folder / name, document(*parts, **options))


def merged(folder: Path, *files: OpenDrive) -> tuple[OpenDrive, list[str]]:
    root, lines = merge_networks(files)
    return saved(root, folder / "merged.xodr"), lines


def saved(root: object, path: Path) -> OpenDrive:
    stream = io.BytesIO()
    write_tree(root, stream)
    path.write_bytes(stream.getvalue())
    return read_xodr(path)


def beyond(x: float = 100.0, y: float = 0.0, hdg: float = 0.0, number: str = "1", lanes: str | None = None) -> str:
    plan = geometry("<line/>", 50.0, x=x, y=y, hdg=hdg)
    return road(number, plan, 50.0) if lanes is None else road(number, plan, 50.0, lanes=lanes)


def test_ends_that_meet_are_linked(tmp_path: Path) -> None:
    found, lines = merged(tmp_path, file(tmp_path, "a", road("1")), file(tmp_path, "b", beyond()))
    assert lines == ["1 pair of ends of roads that meet: linked", "1 id in use before: given anew"]
    assert found.roads.id == ("1", "2")
    assert found.roads.link_kind.tolist() == [[LinkKind.NONE, LinkKind.ROAD], [LinkKind.ROAD, LinkKind.NONE]]
    assert (found.roads.link[0, 1], found.roads.link[1, 0]) == (1, 0)
    assert (found.roads.contact[0, 1], found.roads.contact[1, 0]) == (End.START, End.END)
    graph = driving_of(found)
    # Lanes 1, 0, -1 of either road: along s on the right, against s on the left.
    assert list(zip(graph.start.tolist(), graph.end.tolist(), strict=True)) == [(4, 10), (7, 1)]


def test_two_ends_may_meet(tmp_path: Path) -> None:
    turned = geometry("<line/>", 50.0, x=150.0, hdg=np.pi)
    found, _ = merged(tmp_path, file(tmp_path, "a", road("1")), file(tmp_path, "b", road("7", turned, 50.0)))
    assert found.roads.contact[:, 1].tolist() == [End.END, End.END]
    assert found.lanes.successor[found.lanes.id == -1].tolist() == [1, 1]
    assert len(driving_of(found).start) == 2


@pytest.mark.parametrize(
    "other",
    [
        beyond(x=100.02),
        beyond(hdg=0.02),
        beyond(lanes=section(0.0, lane(1, (0, 3.0)), lane(-1, (0, 3.0)))),
        beyond(lanes=section(0.0, lane(1, (0, 3.5), kind="biking"), lane(-1, (0, 3.5), kind="biking"))),
    ],
    ids=["apart", "turned", "narrower", "another type"],
)
def test_ends_that_do_not_fit_are_not_linked(tmp_path: Path, other: str) -> None:
    found, lines = merged(tmp_path, file(tmp_path, "a", road("1")), file(tmp_path, "b", other))
    assert lines[0] == "0 pairs of ends of roads that meet: linked"
    assert not found.roads.link_kind.any()


def test_ends_that_meet_several_are_left_alone(tmp_path: Path) -> None:
    files = file(tmp_path, "a", road("1")), file(tmp_path, "b", beyond(number="5"), beyond(number="6"))
    found, lines = merged(tmp_path, *files)
    assert lines[-1] == "1 end of roads where several others meet: not linked"
    assert not found.roads.link_kind.any()


def test_the_same_road_is_there_once(tmp_path: Path) -> None:
    link = '<successor elementType="road" elementId="2" contactPoint="start"/>'
    back = '<predecessor elementType="road" elementId="1" contactPoint="end"/>'
    second = road("2", geometry("<line/>", 50.0, x=100.0), 50.0, link=back)
    files = file(tmp_path, "a", road("1")), file(tmp_path, "b", road("1", link=link), second)
    found, lines = merged(tmp_path, *files)
    assert found.roads.id == ("1", "2")
    assert "1 road that an earlier file has: left out" in lines
    # The link that only the second file knows is kept.
    assert (found.roads.link[0, 1], found.roads.link[1, 0]) == (1, 0)
    again, lines = merged(tmp_path, files[1], files[1])
    assert again.roads.id == ("1", "2")
    assert "2 roads that an earlier file has: left out" in lines


def test_references_follow_new_ids(tmp_path: Path) -> None:
    light = '<signal id="1" s="5" t="-4" orientation="+" dynamic="yes" type="1000001"/>'
    parts = [
        road("1", link='<successor elementType="junction" elementId="9"/>', more=f"<signals>{light}</signals>"),
        road("2", geometry("<line/>", 9.0, x=100.0), 9.0, junction="9"),
        '<controller id="3"><control signalId="1"/></controller>',
        (
            '<junction id="9" name=""><connection id="0" incomingRoad="1" connectingRoad="2" contactPoint="start"/>'
            '<controller id="3"/></junction>'
        ),
    ]
    moved = [part.replace('y="0.0"', 'y="500.0"') for part in parts]
    found, _ = merged(tmp_path, file(tmp_path, "a", *parts), file(tmp_path, "b", *moved))
    assert len({*found.roads.id, *found.junctions.id}) == 6
    assert found.roads.junction.tolist() == [-1, 0, -1, 1]
    assert found.roads.link[2, 1] == 1
    assert (found.connections.incoming.tolist(), found.connections.connecting.tolist()) == ([0, 2], [1, 3])
    signals = [item.attributes["id"] for item in found.furniture]
    assert [item.signal_ids for item in found.controllers] == [(name,) for name in signals]
    assert [name for _, name in found.junctions.controllers] == [item.id for item in found.controllers]


def test_files_of_two_frames_are_an_error(tmp_path: Path) -> None:
    one = file(tmp_path, "a", road("1"))
    with pytest.raises(InputError, match="different geoReferences"):
        merge_networks([one, file(tmp_path, "b", road("1"), header=OTHER)])
    moved = one.path.read_text(encoding="utf-8").replace("</geoReference>", '</geoReference><offset x="1" y="0"/>')
    one.path.write_text(moved, encoding="utf-8")
    with pytest.raises(InputError, match="different offsets"):
        merge_networks([file(tmp_path, "c", road("1")), read_xodr(one.path)])


def quarters(file: OpenDrive) -> list[object]:
    """Return a file as four areas side by side."""
    middle = [float(np.median(values)) for values in (file.plan_view.x, file.plan_view.y)]

    def area(east: bool, north: bool) -> object:
        def inside(x: FloatArray, y: FloatArray) -> BoolArray:
            return np.asarray(((x >= middle[0]) == east) & ((y >= middle[1]) == north))

        return inside

    return [area(east, north) for east in (False, True) for north in (False, True)]


@pytest.mark.parametrize("scene", [*SMALL_SCENES, scene_named("andorra_ordino")], ids=str)
def test_four_quarters_are_the_whole(scene: Scene, conversions: Conversions, tmp_path: Path) -> None:
    whole = read_xodr(conversions.of(scene).path)
    parts = []
    for k, inside in enumerate(quarters(whole)):
        root, _ = crop_network(whole, choose_inside(whole, inside))  # type: ignore[arg-type]
        parts.append(saved(root, tmp_path / f"{k}.xodr"))
    assert sum(len(part.roads.id) for part in parts) > len(whole.roads.id)
    found, _ = merged(tmp_path, *parts)
    assert found.misfits == ()
    assert found.roads.length.sum() == pytest.approx(whole.roads.length.sum(), abs=1e-5)
    # A road that was cut has a lane more, and a step from lane to lane more, for each of its lanes.
    before, after = driving_of(whole), driving_of(found)
    nodes = [int(graph.along.sum() + graph.against.sum()) for graph in (before, after)]
    assert nodes[1] > nodes[0]
    assert len(after.start) - len(before.start) == nodes[1] - nodes[0]
    steps = [places(file, graph) for file, graph in ((whole, before), (found, after))]
    assert steps[0] <= steps[1]
    junctions = [sorted(np.diff(file.junctions.start).tolist()) for file in (whole, found)]
    assert junctions[0] == junctions[1]
    tags = [
        sorted(item.attributes["type"] for item in file.furniture if item.kind == "signal") for file in (whole, found)
    ]
    assert tags[0] == tags[1]
    assert len(found.controllers) == len(whole.controllers)


def places(file: OpenDrive, graph: object) -> set[tuple[int, ...]]:
    """Return the steps between roads by where they are, to 1 cm, and the lanes' sides."""
    out = set()
    for a, b in zip(graph.start.tolist(), graph.end.tolist(), strict=True):  # type: ignore[attr-defined]
        rows = [file.sections.road[file.lanes.section[node // 2]] for node in (a, b)]
        if rows[0] == rows[1]:
            continue
        ends = [
            0.0 if node % 2 == side else file.roads.length[row]
            for node, row, side in zip((a, b), rows, (1, 0), strict=True)
        ]
        x, y, _ = pose(file, np.array(rows), np.array(ends))
        lanes = [int(file.lanes.id[node // 2]) for node in (a, b)]
        out.add((*np.round([*x, *y], 2).tolist(), *lanes))
    return out


def test_the_header_speaks_for_all(tmp_path: Path) -> None:
    def header(credit: str, north: int, minor: int) -> str:
        data = f'<userData code="attribution" value="{credit}"/>'
        return f'<header revMajor="1" revMinor="{minor}" north="{north}" south="0" east="9" west="0">{data}</header>'

    files = [
        file(tmp_path, "a", road("1"), header=header("A", 5, 6)),
        file(tmp_path, "b", beyond(y=50.0), header=header("B", 70, 7)),
        file(tmp_path, "c", beyond(y=90.0), header=header("A", 3, 4)),
    ]
    found, _ = merged(tmp_path, *files)
    assert found.header.revision == (1, 7)
    assert found.header.attributes["north"] == "70"
    text = (tmp_path / "merged.xodr").read_text(encoding="utf-8")
    assert [text.count(f'value="{credit}"') for credit in "AB"] == [1, 1]


def test_unknown_elements_stay(tmp_path: Path) -> None:
    unknown = '<userData code="mine"><deep x="1"/></userData>'
    one = file(tmp_path, "a", road("1"))
    merged(tmp_path, one, file(tmp_path, "b", beyond().replace("</road>", f"{unknown}</road>")))
    root = etree.parse(str(tmp_path / "merged.xodr")).getroot()
    assert [item.get("x") for item in root.findall("road/userData/deep")] == ["1"]
