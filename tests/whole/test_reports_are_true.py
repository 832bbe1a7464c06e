"""What a report says is what has become of the OSM file: nothing is lost in silence, and all counts are true."""

from __future__ import annotations

import gzip
import hashlib
import re
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from lxml import etree
from scene_files import SCENES, Conversion, Conversions, Scene

from osm2xodr.checking import CheckOptions, check_file
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.osmParsing import ParseOptions, parse_osm

# What cars do not drive on, whoever maps it so; every other way with a ``highway`` has to be accounted for.
NOT_FOR_CARS = frozenset(
    {
        *("footway", "path", "cycleway", "bridleway", "steps", "corridor", "elevator", "platform", "via_ferrata"),
        *("services", "rest_area", "crossing", "bus_stop", "no"),
    }
)
# Codes that say that a way is no road of the output, and why.
GONE = frozenset(
    {
        *("area", "closed", "not-built", "highway-class", "inside-junction", "within-junction"),
        *("duplicate-way", "short-way", "absent-node"),
    }
)
ON_THE_ROAD = ("gate", "lift_gate", "swing_gate", "bollard", "block", "toll_booth", "cattle_grid")
CAR_RESTRICTIONS = ("restriction", "restriction:motorcar", "restriction:motor_vehicle", "restriction:vehicle")
FURNITURE = frozenset({"traffic_signals", "stop", "give_way", "crossing"})


@pytest.fixture(params=SCENES, ids=str)
def conversion(request: pytest.FixtureRequest, conversions: Conversions) -> Conversion:
    scene: Scene = request.param
    return conversions.of(scene)


def osm_elements(path: Path) -> tuple[dict[int, tuple[dict[str, str], list[int]]], dict[int, dict[str, str]]]:
    """Return tags and nodes of the ways, and tags of the nodes, by id."""
    raw = path.read_bytes()
    root = etree.fromstring(gzip.decompress(raw) if path.suffix == ".gz" else raw)
    ways = {
        int(way.attrib["id"]): (_tags(way), [int(member.attrib["ref"]) for member in way.iter("nd")])
        for way in root.iter("way")
    }
    return ways, {int(node.attrib["id"]): _tags(node) for node in root.iter("node")}


def _tags(element: etree._Element) -> dict[str, str]:
    return {str(tag.attrib["k"]): str(tag.attrib["v"]) for tag in element.iter("tag")}


def user_data(root: etree._Element, code: str) -> list[str]:
    return [str(item.attrib["value"]) for item in root.iter("userData") if item.get("code") == code]


def carried_ways(root: etree._Element) -> set[int]:
    return {int(number) for value in user_data(root, "osm_way_ids") for number in value.split()}


def told_about(report: dict[str, Any]) -> set[str]:
    return {item["osm_id"] for item in report["diagnostics"] if item["osm_id"]}


def test_every_drivable_way_is_there_or_named(conversion: Conversion) -> None:
    """Those that were not asked for are counted by the value that tells them, no more and no less."""
    report: dict[str, Any] = conversion.report
    root = etree.parse(conversion.path).getroot()
    ways, _ = osm_elements(conversion.scene.osm)
    carried = carried_ways(root)
    gone = {item["osm_id"] for item in report["diagnostics"] if item["kind"] != "guessed" and item["code"] in GONE}
    said = Counter[tuple[str, str]]()
    for item in report["diagnostics"]:
        if item["code"] == "way-selection":
            found = re.fullmatch(
                r"(\d+) ways? left out: (\w+)=(\S+) is not among the ways asked for", item["message"]
            )
            assert found, item
            said[found[2], found[3]] = int(found[1])
    counted, lost = Counter[tuple[str, str]](), []
    for number, (tags, _) in ways.items():
        highway, service = tags.get("highway", "no"), tags.get("service", "")
        if highway in NOT_FOR_CARS or number in carried or f"way/{number}" in gone:
            continue
        if highway == "service" and ("service", service) in said:
            counted["service", service] += 1
        elif ("highway", highway) in said and tags.get("area") != "yes":
            counted["highway", highway] += 1
        elif highway != "pedestrian" or tags.get("area") != "yes":
            lost.append((number, tags))
    assert lost == []
    assert counted == said
    assert carried <= ways.keys()


def test_every_bridge_and_tunnel_is_there(conversion: Conversion) -> None:
    """Ways of which junctions leave mere slivers of a road, shorter than half a metre, leave none."""
    root = etree.parse(conversion.path).getroot()
    ways, _ = osm_elements(conversion.scene.osm)
    for key, off in (("bridge", {"no"}), ("tunnel", {"no", "culvert", "flooded"})):
        tagged = {number for number in carried_ways(root) if ways[number][0].get(key, "no") not in off}
        tagged -= {number for number in tagged if key == "tunnel" and ways[number][0].get("bridge", "no") != "no"}
        written = {
            int(number)
            for element in root.iter(key)
            for data in element.iter("userData")
            for number in data.get("value", "").split()
        }
        assert written <= tagged
        assert len(tagged - written) <= 0.15 * len(tagged), (key, tagged - written)


def test_every_turn_restriction_is_read_or_named(conversion: Conversion) -> None:
    """Which movements follow from them is the matter of other tests."""
    raw = conversion.scene.osm.read_bytes()
    root = etree.fromstring(gzip.decompress(raw) if conversion.scene.osm.suffix == ".gz" else raw)
    network = parse_osm(conversion.scene.osm, ParseOptions(), Diagnostics())
    known = {f"relation/{item.osm_relation_id}" for item in network.restrictions} | told_about(conversion.report)
    silent = []
    for relation in root.iter("relation"):
        tags = _tags(relation)
        about_cars = any(key in tags for key in CAR_RESTRICTIONS) and "motor" not in tags.get("except", "")
        if tags.get("type") in CAR_RESTRICTIONS and about_cars and f"relation/{relation.get('id')}" not in known:
            silent.append((relation.get("id"), tags))
    assert silent == []


def test_values_that_are_of_no_use_are_named(conversion: Conversion) -> None:
    """Whatever stands for a number on a road that is carried, and is none that can be read without care."""
    report: dict[str, Any] = conversion.report
    ways, _ = osm_elements(conversion.scene.osm)
    told: dict[str, str] = {}
    for item in report["diagnostics"]:
        told[item["osm_id"]] = told.get(item["osm_id"], "") + item["message"]
    number = r"\d+(\.\d+)?"
    plain = {
        **dict.fromkeys(("lanes", "lanes:forward", "lanes:backward"), r"\d+"),
        **dict.fromkeys(("maxspeed", "maxspeed:forward", "maxspeed:backward"), r"\d+( mph)?|none|walk|[A-Z]{2}:\w+"),
        **dict.fromkeys(("width", "est_width"), rf"{number} ?(m|ft)?|\d+'(\d+\")?"),
        "layer": r"-?\d",
        "incline": rf"[-+]?{number} ?[%°]?|up|down|yes|no",
        "oneway": "yes|no|-1",
    }
    silent = []
    for way in carried_ways(etree.parse(conversion.path).getroot()):
        tags = ways[way][0]
        for key in plain.keys() & tags.keys():
            if not re.fullmatch(plain[key], tags[key]) and tags[key] not in told.get(f"way/{way}", ""):
                silent.append((way, key, tags[key]))
    assert silent == []


def test_what_stands_on_the_road_is_there_or_named(conversion: Conversion) -> None:
    report: dict[str, Any] = conversion.report
    root = etree.parse(conversion.path).getroot()
    ways, nodes = osm_elements(conversion.scene.osm)
    on_streets = {node for number in carried_ways(root) for node in ways[number][1]}
    known = {part for value in user_data(root, "osm_id") for part in value.split()} | told_about(report)
    wanted = {
        node
        for node in on_streets & nodes.keys()
        if nodes[node].get("barrier") in ON_THE_ROAD
        or nodes[node].get("railway") in ("level_crossing", "tram_level_crossing")
        or nodes[node].get("highway") == "mini_roundabout"
    }
    assert {node for node in wanted if f"node/{node}" not in known} == set()


def test_every_signal_sign_and_crossing_is_there_or_named(conversion: Conversion) -> None:
    report: dict[str, Any] = conversion.report
    root = etree.parse(conversion.path).getroot()
    ways, nodes = osm_elements(conversion.scene.osm)
    carried = carried_ways(root)
    on_streets = {node for number in carried for node in ways[number][1]}
    known = {part for value in user_data(root, "osm_id") for part in value.split()} | told_about(report)
    wanted = {node: tags for node, tags in nodes.items() if node in on_streets and tags.get("highway") in FURNITURE}
    assert {node: tags for node, tags in wanted.items() if f"node/{node}" not in known} == {}


def test_what_is_named_is_in_the_osm_file(conversion: Conversion) -> None:
    report: dict[str, Any] = conversion.report
    root = etree.parse(conversion.path).getroot()
    ways, nodes = osm_elements(conversion.scene.osm)
    known = {f"way/{number}" for number in ways} | {f"node/{number}" for number in nodes}
    named = {part for value in user_data(root, "osm_id") for part in value.split()} | told_about(report)
    # Ways that reach beyond the file have nodes there.
    assert {name for name in named if not name.startswith("relation/")} - known <= _missing_nodes(ways, nodes)


def _missing_nodes(ways: dict[int, tuple[dict[str, str], list[int]]], nodes: dict[int, Any]) -> set[str]:
    return {f"node/{node}" for _, members in ways.values() for node in members if node not in nodes}


def test_counts_are_those_of_what_is_listed(conversion: Conversion) -> None:
    report: dict[str, Any] = conversion.report
    listed = Counter((item["kind"], item["code"]) for item in report["diagnostics"])
    counted = {(item["kind"], item["code"]): item["count"] for item in report["counts"]}
    assert counted == dict(listed)
    # Each line of -v names as many, and the last line all.
    lines = conversion.messages.splitlines()
    for (kind, code), count in listed.items():
        line = next(line for line in lines if f" {code}: " in line and line.startswith(f"  {kind} "))
        assert int(line.split()[1].replace(",", "")) == count
    kinds = Counter(kind for kind, _ in listed.elements())
    said = [int(text.replace(",", "")) for text in re.findall(r"\d[\d,]*(?= )", lines[-1])]
    assert said == [kinds["guessed"], kinds["dropped"], kinds["repaired"]]
    start = next(k for k, line in enumerate(lines) if " km of road, " in line)
    assert len(lines) - start <= 9


def test_statistics_are_those_of_the_file(conversion: Conversion) -> None:
    statistics: dict[str, Any] = conversion.report["statistics"]  # type: ignore[assignment]
    root = etree.parse(conversion.path).getroot()
    roads = [road for road in root.iter("road") if road.get("junction") == "-1"]
    connecting = [road for road in root.iter("road") if road.get("junction") != "-1"]
    assert statistics["roads"] == len(roads)
    assert statistics["connecting_roads"] == len(connecting)
    assert statistics["junctions"] == len(root.findall("junction"))
    further = statistics["further"]
    length = sum(float(road.attrib["length"]) for road in roads)
    assert further["road_km"] * 1000.0 == pytest.approx(length, rel=1e-6)
    assert statistics["road_length"] == pytest.approx(length, rel=1e-6)
    assert further["controllers"] == len(root.findall("controller"))
    signals = Counter(signal.get("dynamic") for signal in root.iter("signal"))
    assert (further["traffic_lights"], further["signs"]) == (signals["yes"], signals["no"])
    crossings = [item for item in root.iter("object") if item.get("type") == "crosswalk"]
    assert further["crossings"] == len(crossings)
    assert further["objects"] == len(list(root.iter("object")))
    assert conversion.report["output"] == {
        "file": str(conversion.path),
        "bytes": conversion.path.stat().st_size,
        "xodr_version": "1.7",
        "sha256": hashlib.sha256(conversion.path.read_bytes()).hexdigest(),
    }


def test_every_place_with_little_room_that_check_finds_is_reported(conversion: Conversion) -> None:
    """What the solve knows to be too close for its class may still have the room that `check` asks for."""
    found = check_file(conversion.path, CheckOptions(only=("clearance",), ignore=())).findings
    report: Any = conversion.report
    tight = report["elevation"]["tight"]
    pairs = {frozenset((int(item.road), int(item.text.split()[-1]))) for item in found}
    assert pairs <= {frozenset((item["upper"], item["lower"])) for item in tight}
    said = Counter(item["code"] for item in report["diagnostics"])
    assert sum(said[code] for code in ("clearance", "crossing-without-node", "carriageways-overlap")) == len(tight)
