"""Every stop and give-way sign that OSM has on the roads of real places is there, or the report says why not."""

from __future__ import annotations

import gzip
import math
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from pyproj import Transformer
from scene_files import SCENES, Conversion, Conversions, Scene, scene_named

TYPES = {"stop": "206", "give_way": "205"}
# Stop lines stand before the junction that a node lies on; wide ones are cut back by as much, m.
FAR = 40.0


def yielding_nodes(path: Path, ways: set[int]) -> dict[int, tuple[str, float, float]]:
    """Return the kind, longitude and latitude of all stop and give-way nodes on ways."""
    document = path.read_bytes()
    root = etree.fromstring(gzip.decompress(document) if path.suffix == ".gz" else document)
    on_ways = {
        int(str(item.attrib["ref"]))
        for way in root.iterfind("way")
        if int(str(way.attrib["id"])) in ways
        for item in way.iterfind("nd")
    }
    out = {}
    for node in root.iterfind("node"):
        tags = {str(item.attrib["k"]): str(item.attrib["v"]) for item in node.iterfind("tag")}
        if int(str(node.attrib["id"])) in on_ways and tags.get("highway") in TYPES:
            out[int(str(node.attrib["id"]))] = (
                tags["highway"],
                float(str(node.attrib["lon"])),
                float(str(node.attrib["lat"])),
            )
    return out


def signs(conversion: Conversion) -> list[tuple[str, str, complex]]:
    """Return type, OSM element and place of all signs."""
    out = []
    for road in etree.parse(str(conversion.path)).iterfind("road"):
        for signal in road.iterfind("signals/signal[@dynamic='no']"):
            s, t = float(str(signal.attrib["s"])), float(str(signal.attrib["t"]))
            x, y, hdg = (float(v[0]) for v in conversion.network.roads[str(road.attrib["id"])].pose(np.array([s])))
            (source,) = [str(item.attrib["value"]) for item in signal.iterfind("userData[@code='osm_id']")]
            out.append((str(signal.attrib["type"]), source, complex(x - t * math.sin(hdg), y + t * math.cos(hdg))))
    return out


@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_every_node_gives_a_sign_or_a_reason(scene: Scene, conversions: Conversions) -> None:
    conversion = conversions.of(scene)
    nodes = yielding_nodes(scene.osm, set(conversion.osm.ways))
    diagnostics = conversion.report["diagnostics"]
    assert isinstance(diagnostics, list)
    left_out = {item["osm_id"] for item in diagnostics if item["code"] == "sign-left-out"}
    to_local = Transformer.from_crs("EPSG:4326", conversion.network.georeference, always_xy=True)
    placed = signs(conversion)
    for node, (kind, lon, lat) in nodes.items():
        there = complex(*to_local.transform(lon, lat))
        own = [(code, abs(place - there)) for code, source, place in placed if source == f"node/{node}"]
        own = [(code, distance) for code, distance in own if code in TYPES.values()]
        if not own:
            assert f"node/{node}" in left_out
            continue
        assert {code for code, _ in own} == {TYPES[kind]}
        assert max(distance for _, distance in own) < FAR


# Counted on the map: arms of all-way stops, and signs before junctions.
COUNTED = {
    "andorra_ordino": {"205": 3, "206": 0},
    "fremantle_placement": {"205": 1, "206": 0},
    "montlake_roundabout": {"205": 0, "206": 0},
}


@pytest.mark.parametrize("name", COUNTED)
def test_what_is_counted(name: str, conversions: Conversions) -> None:
    placed = signs(conversions.of(scene_named(name)))
    codes = [code for code, source, _ in placed if source.startswith("node/")]
    assert {code: codes.count(code) for code in COUNTED[name]} == COUNTED[name]
