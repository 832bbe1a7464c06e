"""The crossings of real places, held against OSM and shown to CARLA."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from pyproj import Transformer
from real_readers import carla_answers
from scene_files import Conversion, Conversions, scene_named
from xodr_file import FloatArray

# Crossings of the car roads that no tag closes, counted in the files.
SCENES = (("montlake_roundabout", 24), ("i5_exit_ramp", 27), ("fremantle_placement", 3), ("andorra_ordino", 14))
# As far as a crossing in a junction may be moved onto its arm, and as its middle lies off the way, m.
MOVED = 15.0 + 2.0
ASIDE = 6.0


def crossing_nodes(conversion: Conversion) -> dict[int, FloatArray]:
    """Return where the crossings of a scene's car roads are, by OSM id: x and y, m."""
    path = conversion.scene.osm
    root = etree.fromstring(gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes())
    carried = {str(node) for way in conversion.osm.ways.values() for node in way.node_ids}
    to_local = Transformer.from_crs("EPSG:4326", conversion.network.georeference, always_xy=True)
    found = {}
    for node in root.iterfind("node"):
        tags = {tag.attrib["k"]: tag.attrib["v"] for tag in node.iterfind("tag")}
        number = node.attrib["id"]
        if number in carried and tags.get("highway") == "crossing" and tags.get("crossing") != "no":
            place = to_local.transform(float(node.attrib["lon"]), float(node.attrib["lat"]))
            found[int(number)] = np.array(place)
    return found


def crosswalks_of(path: Path) -> list[str]:
    """Return the OSM ids of the crosswalks of a file."""
    out = []
    for road in etree.parse(path).getroot().iterfind("road"):
        for item in road.iterfind("objects/object[@type='crosswalk']"):
            (data,) = item.iterfind("userData[@code='osm_id']")
            assert 0.0 <= float(item.attrib["s"]) <= float(road.attrib["length"])
            assert len(item.findall("outline/cornerLocal")) >= 4
            out.append(str(data.attrib["value"]))
    return out


def reported(conversion: Conversion) -> dict[str, str]:
    """Return the codes of what the report says about crossings, by OSM id."""
    items: list[dict[str, str]] = conversion.report["diagnostics"]  # type: ignore[assignment]
    return {item["osm_id"]: item["code"] for item in items if item["code"].startswith("crossing-")}


@pytest.mark.parametrize(("name", "count"), SCENES)
def test_each_crossing_of_osm_gives_a_crosswalk_or_is_reported(
    name: str, count: int, conversions: Conversions
) -> None:
    conversion = conversions.of(scene_named(name))
    nodes = crossing_nodes(conversion)
    assert len(nodes) == count
    made = set(crosswalks_of(conversion.path))
    told = {
        osm_id for osm_id, code in reported(conversion).items() if code in ("crossing-left-out", "crossing-merged")
    }
    assert {f"node/{node}" for node in nodes} - made - told == set()
    assert not made & told
    # Most are there.
    assert len(made & {f"node/{node}" for node in nodes}) >= 0.75 * count


@pytest.mark.parametrize(("name", "count"), SCENES)
def test_carla_sees_crosswalks_where_osm_has_crossings(name: str, count: int, conversions: Conversions) -> None:
    conversion = conversions.of(scene_named(name))
    polygons = [np.array(item) for item in carla_answers(conversion.path)["crosswalks"]]
    made = crosswalks_of(conversion.path)
    assert len(polygons) == len(made)
    assert all(polygon.shape == (5, 3) for polygon in polygons)
    middles = np.array([polygon[:4, :2].mean(axis=0) for polygon in polygons])
    moved = {osm_id for osm_id, code in reported(conversion).items() if code == "crossing-moved"}
    nodes = crossing_nodes(conversion)
    checked = 0
    for osm_id in made:
        place = nodes.get(int(osm_id.removeprefix("node/")))
        if place is not None:
            off = np.hypot(*(middles - place).T).min()
            assert off <= (MOVED + ASIDE if osm_id in moved else ASIDE), osm_id
            checked += 1
    assert checked >= 0.75 * count
