"""Files become tables, and what is wrong in them is reported with its line."""

from __future__ import annotations

import gzip
import io
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from sample_road_maps import crossing, furnished_crossing
from xodr_text import HEADER, LINE, TWO_LANES, cubics, document, geometry, lane, read_text, road, section

from osm2xodr.conventions import TARGETS
from osm2xodr.crop_and_merge.document import read_tree
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError
from osm2xodr.model import Rule
from osm2xodr.opendrive.reader import read_xodr
from osm2xodr.opendrive.tables import ABSENT, End, LinkKind, OpenDrive, Shape
from osm2xodr.xodrWriter import WriteOptions, write_xodr


def rules(file: OpenDrive) -> list[str]:
    return [item.rule for item in file.misfits]


# ---------------------------------------------------------------- what our own writer makes


def test_lane_ids_that_were_negated_for_sumo_come_back_as_they_were(tmp_path: Path) -> None:
    road_map = replace(furnished_crossing(), rule=Rule.LEFT_HAND)
    files = []
    for name in ("generic", "sumo"):
        stream = io.BytesIO()
        write_xodr(road_map, stream, WriteOptions(target=TARGETS[name]), Diagnostics())
        (tmp_path / name).write_bytes(stream.getvalue())
        files.append(read_xodr(tmp_path / name))
    usual, negated = files
    assert negated.misfits == ()
    for column in ("id", "predecessor", "successor", "section"):
        assert np.array_equal(getattr(usual.lanes, column), getattr(negated.lanes, column))
    assert usual.lanes.id.tolist()[:3] == [1, 0, -1]
    assert np.array_equal(usual.connections.link_from, negated.connections.link_from)
    assert np.array_equal(usual.connections.link_to, negated.connections.link_to)
    # Signals come in the order in which traffic meets them.
    validity = [
        {(item.kind, item.attributes["id"], item.road, item.s): item.validity for item in file.furniture}
        for file in files
    ]
    assert validity[0] == validity[1]
    assert any(validity[0].values())


def test_files_of_our_writer_come_back_as_they_were(tmp_path: Path) -> None:
    road_map = crossing()
    stream = io.BytesIO()
    write_xodr(road_map, stream, WriteOptions("1.7"), Diagnostics())
    path = tmp_path / "map.xodr"
    path.write_bytes(stream.getvalue())
    file = read_xodr(path)
    assert file.misfits == ()
    assert file.header.geo_reference == road_map.frame.proj
    assert file.header.revision == (1, 7)
    assert file.roads.id == tuple(str(item.id) for item in road_map.roads)
    for name in ("s", "x", "y", "hdg", "length"):
        np.testing.assert_allclose(getattr(file.plan_view, name), getattr(road_map.plan_view, name), atol=1e-7)
    np.testing.assert_array_equal(file.plan_view.start, road_map.plan_view.start)
    arc = file.plan_view.shape == Shape.ARC
    np.testing.assert_allclose(file.plan_view.parameters[arc, 0], road_map.plan_view.curvature[arc])
    np.testing.assert_allclose(file.elevation.a, road_map.elevation.a, atol=1e-7)
    np.testing.assert_allclose(file.elevation.b, road_map.elevation.b, atol=1e-8)
    lanes = [item for one in road_map.roads for part in one.lane_sections for item in part.lanes]
    assert file.lanes.id.tolist() == [item.id for item in lanes]
    assert list(file.lanes.type) == [item.type.value for item in lanes]
    assert file.lanes.successor.tolist() == [ABSENT if item.successor is None else item.successor for item in lanes]
    widths = [width for item in lanes for width in item.widths]
    np.testing.assert_allclose(file.lanes.width.a, [width.a for width in widths])
    connections = [item for junction in road_map.junctions for item in junction.connections]
    assert [file.roads.id[k] for k in file.connections.incoming] == [str(item.incoming_road) for item in connections]
    assert [file.roads.id[k] for k in file.connections.connecting] == [str(c.connecting_road) for c in connections]
    links = [pair for item in connections for pair in item.lane_links]
    assert list(zip(file.connections.link_from.tolist(), file.connections.link_to.tolist(), strict=True)) == links


# ---------------------------------------------------------------- what standard and other writers have


def test_shapes_and_their_parameters(tmp_path: Path) -> None:
    polynomial = '<paramPoly3 aU="1" bU="2" cU="3" dU="4" aV="5" bV="6" cV="7" dV="8"'
    shapes = [
        '<arc curvature="0.01"/>',
        '<spiral curvStart="0.01" curvEnd="0.02"/>',
        '<poly3 a="1" b="2" c="3" d="4"/>',
        f'{polynomial} pRange="arcLength"/>',
        f'{polynomial} pRange="normalized"/>',
    ]
    plan = "".join(geometry(shape, 10.0, 10.0 * k) for k, shape in enumerate(shapes))
    file = read_text(tmp_path, document(road(plan=plan, length=50.0)))
    assert rules(file) == []
    kinds = [Shape.ARC, Shape.SPIRAL, Shape.POLY3, Shape.PARAM_POLY3, Shape.PARAM_POLY3]
    assert file.plan_view.shape.tolist() == kinds
    assert file.plan_view.normalized.tolist() == [False, False, False, False, True]
    assert file.plan_view.parameters[1, :2].tolist() == [0.01, 0.02]
    assert file.plan_view.parameters[3].tolist() == [1, 2, 3, 4, 5, 6, 7, 8]
    assert np.isnan(file.plan_view.parameters[0, 1:]).all()


@pytest.mark.parametrize(
    ("speed", "expected"),
    [
        ('max="50" unit="km/h"', 50 / 3.6),
        ('max="30" unit="mph"', 30 * 0.44704),
        ('max="13.9"', 13.9),
        ('max="no limit"', math.inf),
        ('max="undefined"', math.nan),
    ],
)
def test_speeds_are_in_metres_per_second(tmp_path: Path, speed: str, expected: float) -> None:
    kind = f'<type s="0" type="town"><speed {speed}/></type>'
    lanes = section(0.0, "", lane(-1, (0, 3.5), more=f'<speed sOffset="0" {speed}/>'))
    file = read_text(tmp_path, document(road(more=kind, lanes=lanes)))
    assert rules(file) == []
    assert file.types.type == ("town",)
    assert file.types.speed[0] == pytest.approx(expected, nan_ok=True)
    assert file.lanes.speed[1] == pytest.approx(expected, nan_ok=True)


def test_links_lead_to_rows(tmp_path: Path) -> None:
    first = '<predecessor elementType="junction" elementId="J"/>'
    second = '<predecessor elementType="road" elementId="a b" contactPoint="end"/>'
    third = '<successor elementType="road" elementId="gone" contactPoint="start"/>'
    junction = (
        '<junction id="J" name="" type="direct"><connection id="0" incomingRoad="a b" linkedRoad="2"'
        ' contactPoint="start"><laneLink from="-1" to="-1"/></connection><priority high="1" low="2"/>'
        '<controller id="7"/></junction><controller id="7" name="c"><control signalId="s1"/></controller>'
    )
    file = read_text(
        tmp_path, document(road("a b", link=first), road("2", link=second + third, junction="J"), junction)
    )
    assert rules(file) == []
    assert file.roads.link_kind.tolist() == [
        [LinkKind.JUNCTION, LinkKind.NONE],
        [LinkKind.ROAD, LinkKind.ROAD],
    ]
    assert file.roads.link.tolist() == [[0, ABSENT], [0, ABSENT]]
    assert file.roads.contact.tolist() == [[End.UNSAID, End.UNSAID], [End.END, End.START]]
    assert file.roads.link_id[1] == ("a b", "gone")
    assert file.roads.junction.tolist() == [-1, 0]
    assert file.connections.incoming.tolist() == [0]
    assert file.connections.connecting.tolist() == [1]
    assert file.junctions.priorities == ((0, "1", "2"),)
    assert file.junctions.controllers == ((0, "7"),)
    assert file.controllers[0].signal_ids == ("s1",)


def test_of_several_predecessors_of_a_lane_the_first_counts(tmp_path: Path) -> None:
    link = '<link><predecessor id="-1"/><predecessor id="-2"/><successor id="-1"/></link>'
    file = read_text(tmp_path, document(road(lanes=section(0.0, "", lane(-1, (0, 3.5), more=link)))))
    assert file.lanes.predecessor.tolist() == [ABSENT, -1]
    assert file.lanes.successor.tolist() == [ABSENT, -1]


def test_furniture(tmp_path: Path) -> None:
    corners = '<cornerRoad s="1" t="2" dz="0" height="4"/><cornerRoad s="2" t="2" dz="0" height="4"/>'
    local = '<cornerLocal u="1" v="2" z="0.5" height="4"/>'
    more = (
        f'<objects><object id="o" s="1" t="2" hdg="0.5" width="3"><outlines><outline>{corners}</outline></outlines>'
        '<validity fromLane="-2" toLane="-1"/></object>'
        f'<object id="p" s="1" t="2"><outline>{local}</outline></object>'
        '<bridge id="b" s="10" length="20" type="concrete"/></objects>'
        '<signals><signal id="x" s="5" t="-4" zOffset="2.5" hOffset="0.1" dynamic="no"/>'
        '<signalReference id="x" s="6" t="4"/></signals>'
    )
    file = read_text(tmp_path, document(road(), road("2", more=more)))
    assert rules(file) == []
    assert [item.kind for item in file.furniture] == ["object", "object", "bridge", "signal", "signalReference"]
    outlined, other, bridge, signal, _ = file.furniture
    assert outlined.road == 1
    assert outlined.outlines == (((1, 2, 0, 4), (2, 2, 0, 4)),)
    assert outlined.local_outlines == (False,)
    assert outlined.validity == ((-2, -1),)
    assert (outlined.width, outlined.hdg) == (3, 0.5)
    assert math.isnan(outlined.length)
    assert other.outlines == (((1, 2, 0.5, 4),),)
    assert other.local_outlines == (True,)
    assert (bridge.s, bridge.length) == (10, 20)
    assert (signal.z_offset, signal.hdg, signal.attributes["dynamic"]) == (2.5, 0.1, "no")


def test_outlines_come_before_the_older_outline(tmp_path: Path) -> None:
    old = '<outline><cornerLocal u="1" v="2" z="0" height="0"/></outline>'
    new = '<outlines><outline id="0"><cornerLocal u="3" v="4" z="0" height="0"/></outline></outlines>'
    more = (
        f'<objects><object id="o" s="1" t="2">{old}{new}</object><object id="p" s="1" t="2">{old}</object></objects>'
    )
    both, alone = read_text(tmp_path, document(road(more=more))).furniture
    assert both.outlines == (((3, 4, 0, 0),),)
    assert alone.outlines == (((1, 2, 0, 0),),)
    assert both.old_outline == alone.old_outline == ((1, 2, 0, 0),)


def test_repeats(tmp_path: Path) -> None:
    numbers = 'heightStart="1" heightEnd="1" zOffsetStart="0" zOffsetEnd="0"'
    more = (
        '<objects><object id="o" s="1" t="2" radius="0.5">'
        f'<repeat s="1" length="20" distance="5" tStart="2" tEnd="3" widthStart="0.4" {numbers}/>'
        f'<repeat s="30" length="2" distance="0" tStart="2" tEnd="2" {numbers}/></object></objects>'
    )
    file = read_text(tmp_path, document(road(more=more)))
    (item,) = file.furniture
    assert rules(file) == []
    assert item.radius == 0.5
    assert item.repeats[0] == (1, 20, 5, 2, 3, 0.4)
    assert item.repeats[1][:5] == (30, 2, 0, 2, 2)
    assert math.isnan(item.repeats[1][5])


def test_header_and_where_its_texts_come_from(tmp_path: Path) -> None:
    header = (
        '<header revMajor="1" revMinor="4" vendor="v">'
        "<geoReference>\n<![CDATA[\n +proj=utm +zone=32 \n]]></geoReference>"
        '<offset x="1" y="2" z="3" hdg="0.1"/><userData code="c" value="v"/></header>'
    )
    file = read_text(tmp_path, document(road(more='<userData code="osm" value="17"/>'), header=header))
    assert rules(file) == []
    assert file.header.revision == (1, 4)
    assert file.header.attributes["vendor"] == "v"
    assert file.header.geo_reference == "+proj=utm +zone=32"
    assert file.header.offset == (1, 2, 3, 0.1)
    assert dict(file.provenance) == {(-1, "c"): "v", (0, "osm"): "17"}


def test_a_namespace_is_reported_and_ignored(tmp_path: Path) -> None:
    text = document(road()).replace("<OpenDRIVE>", '<OpenDRIVE xmlns="http://code.asam.net/simulation">')
    file = read_text(tmp_path, text)
    assert rules(file) == ["namespace"]
    assert file.roads.id == ("1",)


def test_packed_files(tmp_path: Path) -> None:
    path = tmp_path / "map.xodr.gz"
    path.write_bytes(gzip.compress(document(road("7")).encode()))
    assert read_xodr(path).roads.id == ("7",)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "iso-8859-1", "windows-1252"])
def test_encodings(tmp_path: Path, encoding: str) -> None:
    text = document(road().replace('name=""', 'name="Straße"')).replace("UTF-8", encoding)
    path = tmp_path / "map.xodr"
    path.write_bytes(text.encode(encoding))
    assert read_xodr(path).roads.name == ("Straße",)


def test_lines_beyond_65535(tmp_path: Path) -> None:
    file = read_text(tmp_path, document("\n" * 70_000 + road("7").replace('length="100.0"', 'length="x"', 1)))
    assert file.roads.line.tolist() == [70_004]
    assert (file.misfits[0].rule, file.misfits[0].line) == ("bad-number", 70_004)


# ---------------------------------------------------------------- damage


@pytest.mark.parametrize(
    ("text", "rule", "words"),
    [
        (road(plan=""), "missing-element", "planView"),
        (road(plan=geometry("", 100.0)), "missing-shape", "shape"),
        (road(plan=geometry("<line/><line/>", 100.0)), "repeated-element", "shape"),
        (road(plan=geometry('<line/><userData code="a" value="b"/>', 100.0)), "misplaced-user-data", "geometry"),
        (road(elevation='<userData code="a" value="b"/>'), "misplaced-user-data", "elevationProfile"),
        (road(elevation='<elevation s="0" a="nan" b="0" c="0" d="0"/>'), "bad-number", "a='nan'"),
        (road(elevation='<elevation s="0" a="1,5" b="0" c="0" d="0"/>'), "bad-number", "1,5"),
        (road(elevation='<elevation s="0" b="0" c="0" d="0"/>'), "missing-attribute", "attribute a"),
        (road(elevation=cubics("elevation", (5, 1.0), (0, 0.0))), "unsorted-records", "elevation"),
        (road(lanes=""), "missing-element", "laneSection"),
        (road(lanes=section(0.0, centre="")), "missing-element", "centre"),
        (road(lanes=section(50.0, "", "") + section(0.0)), "unsorted-records", "laneSection"),
        (road(lanes=section(0.0, lane(-1, (0, 3.0)))), "misplaced-element", "lane -1"),
        (road(lanes=section(0.0, "", lane(-2, (0, 3.0)) + lane(-1, (0, 3.0)))), "unsorted-records", "left to right"),
        (road(lanes=TWO_LANES.replace('id="-1"', 'id="minus"')), "bad-number", "minus"),
        (road(link='<successor elementType="road" elementId="1" contactPoint="top"/>'), "bad-value", "top"),
        (road(link='<successor elementType="rail" elementId="1" contactPoint="end"/>'), "bad-value", "rail"),
        (road(link='<successor elementId="1" contactPoint="end"/>'), "missing-attribute", "elementType"),
        (road().replace('id="1"', "", 1), "missing-attribute", "id"),
        (road(more="<wheel/>"), "unknown-element", "wheel"),
        (road(more='<include file="x.xml"/>'), "include", "x.xml"),
        (road().replace("<link>", "<link/><link>"), "repeated-element", "link"),
        ("<junction><connection/></junction>", "missing-attribute", "id"),
        (HEADER, "repeated-element", "header"),
    ],
)
def test_damage_is_reported_and_does_no_harm(tmp_path: Path, text: str, rule: str, words: str) -> None:
    file = read_text(tmp_path, document(text))
    found = [item for item in file.misfits if item.rule == rule and words in item.text]
    assert found, file.misfits
    assert found[0].line > 2


def test_records_out_of_order_are_sorted(tmp_path: Path) -> None:
    lanes = section(50.0, lane(1, (0, 2.0))) + section(0.0, lane(1, (5, 4.0), (0, 3.0)))
    file = read_text(tmp_path, document(road(elevation=cubics("elevation", (5, 1.0), (0, 0.0)), lanes=lanes)))
    assert file.elevation.s.tolist() == [0, 5]
    assert file.sections.s.tolist() == [0, 50]
    assert file.sections.end.tolist() == [50, 100]
    assert file.lanes.width.s.tolist() == [0, 5, 0]
    assert file.lanes.width.a.tolist() == [3, 4, 2]


def test_references_to_missing_elements(tmp_path: Path) -> None:
    connection = '<junction id="3"><connection id="0" incomingRoad="8" connectingRoad="9"/></junction>'
    file = read_text(tmp_path, document(road(junction="4"), connection))
    assert file.roads.junction.tolist() == [ABSENT]
    assert file.roads.junction_id == ("4",)
    assert file.connections.incoming.tolist() == [ABSENT]
    assert file.connections.connecting_id == ("9",)


def test_ids_used_twice_lead_to_the_first(tmp_path: Path) -> None:
    link = '<successor elementType="road" elementId="2" contactPoint="start"/>'
    file = read_text(tmp_path, document(road("1", link=link), road("2"), road("2")))
    assert file.roads.link[0].tolist() == [ABSENT, 1]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "not XML"),
        (b"once upon a time", "not XML"),
        (b"<OpenDRIVE><road>", "not XML"),
        (b"<osm/>", "not OpenDRIVE: its root is <osm>"),
        (b"\x1f\x8bnonsense", "cannot read"),
        (b'<?xml version="1.0" encoding="foo"?><OpenDRIVE/>', "unknown encoding: foo"),
        (b'<?xml version="1.0" encoding="zip"?><OpenDRIVE/>', "is not a text encoding"),
        (b'<?xml version="1.0" encoding="big5"?><OpenDRIVE a="\xff"/>', "can't decode byte 0xff"),
        (b'<!DOCTYPE a [<!ENTITY b "c">]><OpenDRIVE>&b;</OpenDRIVE>', "<!DOCTYPE>"),
    ],
)
def test_other_files_give_one_sentence(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "map.xodr"
    path.write_bytes(content)
    with pytest.raises(InputError, match=re.escape(words)) as error:
        read_xodr(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "declaration",
    [
        *(
            '<?xml version="1.0" encoding="utf8"?>',
            '\n\n<?xml version="1.0"?>',
            '<!-- licence --> <?xml version="1.0"?>',
        ),
        '<?xml version="1.0" encoding="big5"?>',
    ],
)
@pytest.mark.parametrize("pack", [bytes, gzip.compress])
def test_declarations_that_other_readers_take(
    tmp_path: Path, declaration: str, pack: Callable[[bytes], bytes]
) -> None:
    text = document(road("a"))
    path = tmp_path / "map.xodr"
    path.write_bytes(pack((declaration + text[text.index("<OpenDRIVE") :]).encode()))
    assert len(read_xodr(path).roads.id) == 1
    assert len(read_tree(path)) == 2


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_xodr(tmp_path / "none.xodr")


_SOUND = document(
    road("1", geometry('<arc curvature="0.01"/>', 100.0), elevation=cubics("elevation", (0, 1.0)), more="<objects/>"),
    '<junction id="9"><connection id="0" incomingRoad="1" connectingRoad="1" contactPoint="start">'
    '<laneLink from="-1" to="-1"/></connection></junction>',
)
_VALUES = [match.span(1) for match in re.finditer(r'"([^"]*)"', _SOUND) if match.start() > 60]
_ELEMENTS = [match.span() for match in re.finditer(r"<(?!/|\?|!|OpenDRIVE)[^<>]*/>", _SOUND)]


@given(
    st.sampled_from(_VALUES),
    st.sampled_from(["", "x", "nan", "-inf", "1e999", "-1", "0", "99999999999999999999", "1_0", "\u0663"]),
)
def test_no_value_makes_it_fail(tmp_path_factory: pytest.TempPathFactory, span: tuple[int, int], value: str) -> None:
    try:
        file = read_text(tmp_path_factory.mktemp("value"), _SOUND[: span[0]] + value + _SOUND[span[1] :])
    except InputError as error:
        # A width of 3.5 m that grows by 10 m each metre.
        assert "a sound file can have" in str(error)  # noqa: PT017 - all others can be read
        return
    assert len(file.roads.id) == 1


@given(st.sampled_from(_ELEMENTS))
def test_no_missing_element_makes_it_fail(tmp_path_factory: pytest.TempPathFactory, span: tuple[int, int]) -> None:
    file = read_text(tmp_path_factory.mktemp("element"), _SOUND[: span[0]] + _SOUND[span[1] :])
    assert len(file.roads.id) == 1
    assert LINE not in file.roads.id


def test_a_lane_that_opens_has_the_height_that_it_opens_with(tmp_path: Path) -> None:
    more = '<height sOffset="0" inner="0" outer="0"/><height sOffset="9" inner="0.1" outer="0.2"/>'
    walk = lane(-1, (0, 1.5), kind="sidewalk", more=more)
    file = read_text(tmp_path, document(road(lanes=section(0.0, right=walk))))
    assert file.lanes.height.max(axis=0).tolist() == [0.1, 0.2]
