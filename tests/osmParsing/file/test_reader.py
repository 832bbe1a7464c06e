import bz2
import gc
import gzip
import io
import lzma
import os
import zipfile
from array import array
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import osmium
import pytest
from osm_builder import document, write_osm

from osm2xodr.errors import InputError
from osm2xodr.osmParsing.file.access import RawMember, RawWay
from osm2xodr.osmParsing.file.file_format import OsmFile, open_osm_file
from osm2xodr.osmParsing.file.reader import (
    OtherWays,
    count_contents,
    element_places,
    read_nodes,
    read_ways,
)
from osm2xodr.projection import make_frame, to_geographic

ROADS = frozenset({"residential", "primary"})
KEYS = frozenset({"highway", "name", "lanes"})
NODE_KEYS = frozenset({"highway", "a"})
BIG = 9_000_000_000_000_000_000
ELEMENTS = [
    '<node id="1" lat="50.1" lon="10.1"/>',
    (
        f'<node id="{BIG}" lat="50.2" lon="-10.2"><tag k="highway" v="crossing"/><tag k="a" v="b"/>'
        '<tag k="c" v="d"/></node>'
    ),
    '<node id="-3" lat="-50.3" lon="10.3"><tag k="highway" v="stop"/></node>',
    '<node id="4" lat="91" lon="10"/>',
    '<node id="5" visible="false"/>',
    (
        f'<way id="20"><nd ref="1"/><nd ref="{BIG}"/><nd ref="99"/><nd ref="-3"/>'
        '<tag k="highway" v="primary"/><tag k="name" v="A &amp; B"/><tag k="surface" v="asphalt"/></way>'
    ),
    '<way id="-10"><nd ref="4"/><nd ref="5"/><nd ref="1"/><tag k="highway" v="residential"/></way>',
    '<way id="30"><nd ref="1"/><tag k="highway" v="footway"/></way>',
    '<way id="31"><nd ref="1"/><tag k="building" v="residential"/></way>',
    (
        '<relation id="7"><member type="way" ref="20" role="from"/><member type="node" ref="1" role="via"/>'
        '<member type="way" ref="-10" role="to"/><tag k="type" v="restriction"/>'
        '<tag k="restriction" v="no_left_turn"/></relation>'
    ),
    '<relation id="8"><tag k="type" v="route"/></relation>',
]


def opened(folder: Path, elements: list[str], pack: Callable[[bytes], bytes] = bytes) -> OsmFile:
    path = folder / "area.osm"
    path.write_bytes(pack(document(elements).encode()))
    return open_osm_file(path)


def as_pbf(folder: Path, elements: list[str]) -> OsmFile:
    source = opened(folder, elements)
    target = folder / "area.osm.pbf"
    with osmium.SimpleWriter(str(target)) as writer:
        for item in osmium.FileProcessor(osmium.io.File(str(source.path), "osm")):
            writer.add(item)
    return open_osm_file(target)


@pytest.mark.parametrize(
    "make",
    [
        lambda folder: opened(folder, ELEMENTS),
        lambda folder: opened(folder, ELEMENTS[::-1]),
        lambda folder: opened(folder, ELEMENTS, gzip.compress),
        lambda folder: opened(folder, ELEMENTS, bz2.compress),
        lambda folder: as_pbf(folder, ELEMENTS),
    ],
    ids=["xml", "reversed", "gz", "bz2", "pbf"],
)
def test_every_format_holds_the_same(tmp_path: Path, make: Callable[[Path], OsmFile]) -> None:
    file = make(tmp_path)
    ways, relations = read_ways(file, ROADS, KEYS)
    assert ways == [
        RawWay(-10, array("q", [4, 5, 1]), {"highway": "residential"}),
        RawWay(20, array("q", [1, BIG, 99, -3]), {"highway": "primary", "name": "A & B"}),
    ]
    assert [relation.id for relation in relations] == [7]
    assert relations[0].members == (
        RawMember("way", 20, "from"),
        RawMember("node", 1, "via"),
        RawMember("way", -10, "to"),
    )
    assert relations[0].tags == {"type": "restriction", "restriction": "no_left_turn"}
    nodes = read_nodes(file, np.array([-3, 1, 4, 5, 99, BIG]), NODE_KEYS)
    assert nodes.ids.tolist() == [-3, 1, BIG]
    assert nodes.lon_deg.tolist() == [10.3, 10.1, -10.2]
    assert nodes.lat_deg.tolist() == [-50.3, 50.1, 50.2]
    assert nodes.tags == {-3: {"highway": "stop"}, BIG: {"highway": "crossing", "a": "b"}}


def test_other_ways_come_with_their_nodes_or_only_by_their_tags(tmp_path: Path) -> None:
    elements = [
        f'<way id="{number}"><nd ref="1"/><nd ref="2"/><tag k="{key}" v="{value}"/><tag k="name" v="A"/></way>'
        for number, key, value in (
            (1, "highway", "footway"),
            (2, "highway", "track"),
            (3, "highway", "steps"),
            (4, "barrier", "kerb"),
            (5, "barrier", "gate"),
        )
    ]
    others = OtherWays(
        {"barrier": frozenset({"kerb"})},
        frozenset({"highway", "barrier"}),
        lambda tags: tags.get("highway") == "footway" or "barrier" in tags,
        frozenset({"highway"}),
        lambda tags: tags["highway"] == "track",
    )
    ways, _ = read_ways(opened(tmp_path, elements), ROADS, KEYS, others)
    assert [(way.id, list(way.refs), way.tags) for way in ways] == [
        (1, [1, 2], {"highway": "footway"}),
        (2, [], {"highway": "track"}),
        (4, [1, 2], {"barrier": "kerb"}),
    ]


def test_nodes_are_found_in_any_order_without_negative_ids(tmp_path: Path) -> None:
    elements = [f'<node id="{number}" lat="{number}" lon="1"/>' for number in (7, 3, 9, 1)]
    nodes = read_nodes(opened(tmp_path, elements), np.array([1, 2, 3, 9]), NODE_KEYS)
    assert nodes.ids.tolist() == [1, 3, 9]
    assert nodes.lat_deg.tolist() == [1.0, 3.0, 9.0]


@pytest.mark.parametrize("negative", [False, True])
def test_nodes_without_tags(tmp_path: Path, negative: bool) -> None:
    nodes = read_nodes(opened(tmp_path, ELEMENTS), np.array([-3] * negative + [1, BIG]))
    assert nodes.ids.tolist() == [-3] * negative + [1, BIG]
    assert nodes.tags == {}


def test_tables_for_sorted_files_hold_the_same(tmp_path: Path) -> None:
    elements = [f'<node id="{number}" lat="{number}" lon="1"/>' for number in (1, 3, 7, 9)]
    source = opened(tmp_path, elements)
    header = osmium.io.Header()
    header.set("sorting", "Type_then_ID")
    target = tmp_path / "sorted.osm.pbf"
    with osmium.SimpleWriter(str(target), header=header) as writer:
        for item in osmium.FileProcessor(osmium.io.File(str(source.path), "osm")):
            writer.add(item)
    assert osmium.io.Reader(str(target)).header().get("sorting") == "Type_then_ID"
    nodes = read_nodes(open_osm_file(target), np.array([1, 2, 3, 9]), NODE_KEYS)
    assert nodes.ids.tolist() == [1, 3, 9]
    assert nodes.lat_deg.tolist() == [1.0, 3.0, 9.0]


def test_the_newest_version_counts(tmp_path: Path) -> None:
    def way(version: str, name: str) -> str:
        tags = f'<tag k="highway" v="primary"/><tag k="name" v="{name}"/>'
        return f'<way id="5"{version}><nd ref="1"/><nd ref="2"/>{tags}</way>'

    def name(*elements: str) -> str:
        ways, _ = read_ways(opened(tmp_path, list(elements)), ROADS, KEYS)
        assert len(ways) == 1
        return ways[0].tags["name"]

    assert name(way(' version="2"', "new"), way(' version="1"', "old")) == "new"
    assert name(way("", "first"), way("", "second")) == "second"
    elements = ['<node id="1" lat="1" lon="1"/>', '<node id="1" lat="2" lon="1"/>']
    assert read_nodes(opened(tmp_path, elements), np.array([1]), NODE_KEYS).lat_deg.tolist() == [2.0]


def way(number: int, refs: list[int], tags: str = "", version: str = "") -> str:
    nodes = "".join(f'<nd ref="{ref}"/>' for ref in refs)
    return f'<way id="{number}"{version}>{nodes}<tag k="highway" v="primary"/>{tags}</way>'


@pytest.mark.parametrize(
    ("first", "second", "taken", "said"),
    [
        (way(5, [1, 2, 3]), way(5, [1, 2]), [1, 2, 3], "with different nodes; the longest one is taken"),
        (way(5, [1, 2]), way(5, [1, 2, 3]), [1, 2, 3], "with different nodes; the longest one is taken"),
        (way(5, [1, 2]), way(5, [2, 3]), [2, 3], "with different nodes; the last one is taken"),
        (
            way(5, [1, 2]),
            way(5, [1, 2], '<tag k="lanes" v="3"/>'),
            [1, 2],
            "with different tags; the last one is taken",
        ),
        (way(5, [1, 2]), way(5, [1, 2], '<tag k="note" v="unread"/>'), [1, 2], None),
        (way(5, [1, 2]), way(5, [1, 2]), [1, 2], None),
    ],
)
def test_of_ways_of_one_id_the_longest_is_taken(
    tmp_path: Path, first: str, second: str, taken: list[int], said: str | None
) -> None:
    file = opened(tmp_path, [first, second])
    (found,), _ = read_ways(file, ROADS, KEYS)
    assert list(found.refs) == taken
    assert file.content.repeated == ({} if said is None else {"way/5": said})


def test_versions_are_no_repetition(tmp_path: Path) -> None:
    file = opened(tmp_path, [way(5, [1, 2], version=' version="2"'), way(5, [1, 2, 3], version=' version="1"')])
    (found,), _ = read_ways(file, ROADS, KEYS)
    assert (list(found.refs), file.content.repeated, file.content.several_versions) == ([1, 2], {}, {"way/5"})


@pytest.mark.parametrize("number", [1, -1])
def test_nodes_of_one_id_in_two_places(tmp_path: Path, number: int) -> None:
    nodes = [f'<node id="{number}" lat="{lat}" lon="1"/>' for lat in (1, 2)]
    file = opened(tmp_path, ['<node id="3" lat="1" lon="1"/>', *nodes, nodes[1].replace("1", "3", 1)])
    assert read_nodes(file, np.array([number]), NODE_KEYS).lat_deg.tolist() == [2.0]
    assert file.content.repeated == {f"node/{number}": "with different positions; the last one is taken"}


def test_the_newest_of_nodes_is_taken(tmp_path: Path) -> None:
    nodes = [f'<node id="1" version="{3 - lat}" lat="{lat}" lon="1"/>' for lat in (1, 2)]
    file = opened(tmp_path, nodes)
    assert read_nodes(file, np.array([1]), NODE_KEYS).lat_deg.tolist() == [1.0]
    assert (file.content.repeated, file.content.several_versions) == ({}, {"node/1"})


ODD = [
    *('<node id="1" version="1" lat="1" lon="1"/>', '<node id="2" lat="2" lon="1"/>'),
    '<way id="5"><nd ref="1"/><nd ref="2"/><tag k="highway" v="primary"/><tag k="name" v="Stra\u00dfe"/></way>',
]
ODD_ELEMENTS = {
    "date": [ODD[0].replace("version", 'timestamp="2021-05-06 14:46:03" version'), *ODD[1:]],
    "user": [ODD[0].replace("version", 'uid="99999999999" changeset="-7" version'), *ODD[1:]],
    "version": [ODD[0].replace('version="1"', 'version="first"'), *ODD[1:]],
    "visible": [ODD[0].replace("version", 'visible="yes" version'), *ODD[1:]],
    "center": [*ODD[:2], ODD[2].replace("<nd", '<center lat="1" lon="1"/><nd', 1)],
    "unknown": [*ODD[:2], ODD[2].replace("</way>", '<x><tag k="lanes" v="9"/></x></way>')],
    "geom": [ODD[2].replace('ref="1"', 'ref="1" lat="1" lon="1"').replace('ref="2"', "ref='2' lat='2' lon='1'")],
    "bounds": [*ODD[:2], ODD[2].replace("<nd", '<bounds minlat="1" minlon="1" maxlat="2" maxlon="1"/><nd', 1)],
}


def looks_alike(path: Path) -> OsmFile:
    """Read ODD, in whatever form it is."""
    file = open_osm_file(path)
    (found,), _ = read_ways(file, ROADS, KEYS)
    assert (list(found.refs), found.tags) == ([1, 2], {"highway": "primary", "name": "Stra\u00dfe"})
    nodes = read_nodes(file, np.array([1, 2]), NODE_KEYS)
    assert (nodes.lat_deg.tolist(), nodes.lon_deg.tolist()) == ([1.0, 2.0], [1.0, 1.0])
    return file


@pytest.mark.parametrize("name", ODD_ELEMENTS)
def test_what_streets_do_not_need_may_be_written_in_any_way(tmp_path: Path, name: str) -> None:
    file = looks_alike(write_osm(tmp_path, ODD_ELEMENTS[name]))
    assert file.content.odd or name == "bounds"


@pytest.mark.parametrize(
    ("declaration", "codec"),
    [
        ('<?xml version="1.0" encoding="utf8"?>', "utf-8"),
        ("<?xml version='1.0' encoding='UTF_8'?>", "utf-8"),
        ('\n \n<?xml version="1.0"?>', "utf-8"),
        ('<!-- a licence -->\n<?xml version="1.0" encoding="UTF-8"?>', "utf-8"),
        ('\ufeff\n<?xml version="1.0" encoding="UTF-8"?>', "utf-8"),
        ('<?xml version="1.0" encoding="windows-1252"?>', "cp1252"),
        ('<?xml version="1.0" encoding="latin1"?>', "latin-1"),
        ('<?xml version="1.0" encoding="UTF-16"?>', "utf-16"),
    ],
)
@pytest.mark.parametrize("root", ['<osm version="0.6">', "<osm>", '<osm version="0.5">'])
def test_declarations_and_encodings(tmp_path: Path, declaration: str, codec: str, root: str) -> None:
    path = tmp_path / "area.osm"
    path.write_bytes(f"{declaration}{root}{''.join(ODD)}</osm>".encode(codec))
    looks_alike(path)


def test_what_is_deleted_in_an_odd_file_is_not_there(tmp_path: Path) -> None:
    path = tmp_path / "area.osm"
    path.write_text(
        "<?xml version='1.0' encoding='utf8'?><osm version='0.6'><way id='5' action='delete'><nd ref='1'/>"
        "<tag k='highway' v='primary'/></way></osm>"
    )
    assert read_ways(open_osm_file(path), ROADS, KEYS)[0] == []


def zipped(raw: bytes, **more: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in {"in/area.osm": raw, **more}.items():
            archive.writestr(name, content)
    return out.getvalue()


@pytest.mark.parametrize("pack", [lzma.compress, zipped, partial(zipped, **{"README.txt": b"x"})])
def test_packed_maps(tmp_path: Path, pack: Callable[[bytes], bytes]) -> None:
    path = tmp_path / "area.osm.packed"
    path.write_bytes(pack(document(ODD).encode()))
    copy = looks_alike(path).content.path
    gc.collect()
    assert not copy.exists()


def test_packed_pbf(tmp_path: Path) -> None:
    path = tmp_path / "area.osm.pbf.xz"
    path.write_bytes(lzma.compress(as_pbf(tmp_path, ODD).path.read_bytes()))
    assert looks_alike(path).format == "pbf"


def test_archives_that_are_not_of_one_map(tmp_path: Path) -> None:
    path = tmp_path / "area.zip"
    for raw in (zipped(b"", **{"b.osm": b""}), zipped(b"")[:60]):
        path.write_bytes(raw)
        with pytest.raises(InputError, match=r"is a zip archive of 2 files, not of one map; unpack|is damaged"):
            open_osm_file(path)


def test_deleted_elements_are_not_there(tmp_path: Path) -> None:
    file = opened(
        tmp_path,
        [
            '<node id="1" lat="1" lon="1" action="delete"/>',
            '<node id="2" lat="1" lon="1"/>',
            '<node id="-3" lat="1" lon="1" action="delete"/>',
            '<way id="5" action="delete"><nd ref="1"/><tag k="highway" v="primary"/></way>',
            '<way id="6" visible="false"><nd ref="1"/><tag k="highway" v="primary"/></way>',
            '<way id="7"><nd ref="1"/><tag k="highway" v="primary"/></way>',
            '<relation id="8" action="delete"><tag k="type" v="restriction"/></relation>',
        ],
    )
    ways, relations = read_ways(file, ROADS, KEYS)
    assert [way.id for way in ways] == [7]
    assert relations == []
    assert read_nodes(file, np.array([-3, 1, 2]), NODE_KEYS).ids.tolist() == [2]


def test_counts_for_messages(tmp_path: Path) -> None:
    lanelet = '<relation id="9"><tag k="type" v="lanelet"/></relation>'
    expected = 5, {"primary": 1, "residential": 1, "footway": 1}, 1
    assert count_contents(opened(tmp_path, [*ELEMENTS, lanelet])) == expected


def test_names_that_look_like_addresses_are_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    path = Path("http:area.osm")
    path.write_text(document(ELEMENTS))
    assert len(read_ways(open_osm_file(path), ROADS, KEYS)[0]) == 2


def read_all(path: Path) -> None:
    file = open_osm_file(path)
    read_ways(file, ROADS, KEYS)
    read_nodes(file, np.array([1]), NODE_KEYS)


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        (document(ELEMENTS)[:-60], "XML parsing error at line"),
        (document(['<node id="1" lat="north" lon="1"/>']), "coordinate"),
        (document(['<node id="92233720368547758070" lat="1" lon="1"/>']), "illegal id"),
        (document([f'<node id="1" lat="1" lon="1"><tag k="name" v="{"x" * 70000}"/></node>']), "too long"),
        (document(['<node id="1" lat="1" lon="1"><tag k="name" v="&undefined;"/></node>']), "undefined entity"),
    ],
)
def test_damaged_xml(tmp_path: Path, text: str, cause: str) -> None:
    path = tmp_path / "area.osm"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_all(path)
    message = str(caught.value)
    assert message.startswith(f"{path} cannot be read as OSM data (")
    assert cause in message
    assert "\n" not in message


def test_truncated_pbf(tmp_path: Path) -> None:
    path = as_pbf(tmp_path, ELEMENTS).path
    whole = path.read_bytes()
    for size in (len(whole) - 1, len(whole) // 2):
        path.write_bytes(whole[:size])
        with pytest.raises(InputError, match="download or export it again"):
            read_ways(open_osm_file(path), ROADS, KEYS)


def test_noise_with_the_head_of_a_pbf(tmp_path: Path) -> None:
    path = as_pbf(tmp_path, ELEMENTS).path
    path.write_bytes(path.read_bytes()[:40] + os.urandom(4000))
    with pytest.raises(InputError, match=r"cannot be read as OSM data \("):
        read_ways(open_osm_file(path), ROADS, KEYS)


@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress])
def test_archives_that_end_too_early(tmp_path: Path, pack: Callable[[bytes], bytes]) -> None:
    elements = [f'<node id="{number}" lat="1" lon="{number % 7}"/>' for number in range(1, 20000)]
    whole = pack(document(elements).encode())
    path = tmp_path / "area.osm.x"
    path.write_bytes(whole[: len(whole) * 2 // 3])
    with pytest.raises(InputError, match="damaged or incomplete"):
        read_nodes(open_osm_file(path), np.array([1]), NODE_KEYS)


def test_causes_are_one_printable_line(tmp_path: Path) -> None:
    path = as_pbf(tmp_path, ELEMENTS).path
    whole = path.read_bytes()
    # The name of a feature that is required, which libosmium quotes.
    with osmium.SimpleWriter(osmium.io.File(str(tmp_path / "raw.osm.pbf"), "pbf,pbf_compression=none")) as writer:
        for item in osmium.FileProcessor(str(path)):
            writer.add(item)
    raw = (tmp_path / "raw.osm.pbf").read_bytes()
    assert raw != whole
    assert b"OsmSchema-V0.6" in raw
    path.write_bytes(raw.replace(b"OsmSchema-V0.6", b"Osm\n\x1b\x07ema-V0.6"))
    with pytest.raises(InputError) as caught:
        read_ways(open_osm_file(path), ROADS, KEYS)
    assert "required feature not supported: Osm ema-V0.6" in str(caught.value)
    assert str(caught.value).isprintable()


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
