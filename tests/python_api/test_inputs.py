"""Files of corrections: what they can say, and what is said about what they cannot."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from osm2xodr.errors import InputError
from osm2xodr.model import Corrections, NodeCorrection, WayCorrection
from osm2xodr.python_api import read_corrections

DOCUMENT = Path(__file__).parents[2] / "docs" / "corrections.md"
WAYS = {
    1: WayCorrection(
        lanes={"": 3},
        width=9.0,
        lane_width={1: 3.0, 2: 3.5},
        speed={"": "30 mph"},
        layer=-1,
        clearance=4.5,
        no_u_turn=True,
    ),
    2: WayCorrection(drop=True),
    3: WayCorrection(keep=True, highway="service", lanes={"forward": 2, "backward": 1}),
    4: WayCorrection(keep=True, lane_width={0: 3.25}, speed={"forward": "50", "backward": "none"}),
}
NODES = {
    5: NodeCorrection(z=512.3, no_u_turn=True, join=(6, 7), split=(8,)),
    6: NodeCorrection(drop=True),
    -7: NodeCorrection(join=(9,), split_all=False),
    8: NodeCorrection(split_all=True),
}
EVERYTHING = """
way.2.drop = true
way.3.keep = "service"
way.3.lanes = { forward = 2, backward = 1 }
way.4.keep = true
way.4.lane-width = 3.25
way.4.speed = { forward = 50, backward = "none" }
node.-7.join = 9
node.6.drop = true
node.8.split = true
relation.10.drop = true
relation.11.note = "right as it is"
[way.1]
lanes = 3
width = 9
lane-width = { 1 = 3, 2 = 3.5 }
speed = "30 mph"
layer = -1
clearance = 4.5
no-u-turn = true
drop = false
note = "seen on the spot"
[node.5]
z = 512.3
no-u-turn = true
join = [6, 7]
split = [8]
"""


def write(folder: Path, text: str, name: str = "known.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def feature(properties: Any) -> dict[str, Any]:
    return {"type": "Feature", "geometry": None, "properties": properties}


def write_features(folder: Path, *properties: Any) -> Path:
    document = {"type": "FeatureCollection", "features": [feature(item) for item in properties]}
    return write(folder, json.dumps(document), "known.geojson")


def test_everything_that_can_be_said(tmp_path: Path) -> None:
    found = read_corrections(write(tmp_path, EVERYTHING), shared=True)
    assert found == Corrections(WAYS, NODES, frozenset({10}), shared=True)
    assert len(list(found.entries())) == 21
    assert {("way/1", "lane-width"), ("node/8", "split"), ("relation/10", "drop")} <= set(found.entries())


def test_the_same_as_geojson(tmp_path: Path) -> None:
    own = {"code": "lane-count", "kind": "repaired", "message": "seen", "url": "https://example.org"}
    first = {"lanes": 3.0, "width": 9, "lane-width": {"1": 3, "2": 3.5}, "speed": "30 mph", "layer": -1}
    path = write_features(
        tmp_path,
        {"osm": "way/1", **first, **own},
        {"@id": "way/1", "clearance": 4.5, "no-u-turn": True, "keep": None},
        {"id": "way/2", "drop": True},
        {"osm": "way/3", "keep": "service", "lanes": {"forward": 2, "backward": 1}},
        {"osm": "way/4", "keep": True, "lane-width": 3.25, "speed": {"forward": 50, "backward": "none"}},
        {"osm": "node/5", "z": 512.3, "no-u-turn": True, "join": [6, 7], "split": [8]},
        {"osm": "node/6", "drop": True},
        {"osm": "node/-7", "join": 9},
        {"osm": "node/8", "split": True},
        {"osm": "relation/10", "drop": True},
        {"osm": "way/99", **own, "lanes": None},
        None,
    )
    assert read_corrections(path) == Corrections(WAYS, NODES, frozenset({10}))


def test_a_file_may_say_nothing(tmp_path: Path) -> None:
    assert read_corrections(write(tmp_path, "# nothing yet\n")) == Corrections()
    assert read_corrections(write_features(tmp_path)) == Corrections()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("way.1.lans = 3", "way/1: 'lans' is unknown; do you mean 'lanes'?"),
        ("ways.1.lanes = 3", "'ways' is unknown; do you mean 'way'?; write such as way.123.lanes = 2"),
        ("way = 3", "way is 3; name an element, such as way.123"),
        ("way.main.lanes = 3", "way.main is no id of OpenStreetMap; write such as way.123"),
        ("way.1 = 3", "way/1 is 3; write such as way.1.drop = true"),
        ("way.1.lanes = 0", "way/1: lanes is 0; write a whole number from 1 to 25"),
        ("way.1.lanes = 2.5", "way/1: lanes is 2.5; write a whole number"),
        ("way.1.lanes = true", "way/1: lanes is True; write a whole number"),
        ("way.1.lanes = { left = 2 }", "write numbers of lanes by direction: forward, backward, both_ways"),
        ("way.1.width = 'wide'", "way/1: width is 'wide'; write a number of metres"),
        ("way.1.width = 600", "way/1: width is 600; write metres, from 1.5 to 60"),
        ("way.1.width = nan", "way/1: width is nan; write a number of metres"),
        ("way.1.lane-width = { left = 3 }", "lanes count from 1 on from the left"),
        ("way.1.lane-width = { 1 = 30 }", "write metres, from 0.5 to 10"),
        ("way.1.speed = 'fast'", "way/1: speed is 'fast'; write km/h, or as in OSM"),
        ("way.1.speed = 1000", "way/1: speed is 1000; write km/h"),
        ("way.1.speed = { up = 50 }", "write limits by direction: forward, backward"),
        ("way.1.layer = 1.5", "way/1: layer is 1.5; write a layer, such as 1"),
        ("way.1.layer = 99", "way/1: layer is 99; write a layer"),
        ("way.1.clearance = 0.1", "way/1: clearance is 0.1; write metres, from 1.5 to 350"),
        ("way.1.drop = 1", "way/1: drop is 1; write true or false"),
        ("way.1.keep = 'footway'", "way/1: keep is 'footway'; write true, or the class"),
        ("way.1.note = 5", "way/1: note is 5; write text"),
        ("way.1 = { drop = true, lanes = 2 }", "way/1: drop and lanes exclude each other; give one of them"),
        ("node.1.lanes = 2", "node/1: 'lanes' is unknown; known are drop, z, no-u-turn, join, split, note"),
        ("node.1.z = 'high'", "node/1: z is 'high'; write the height of the road there, m"),
        ("node.1.z = 99999", "node/1: z is 99999; write the height of the road there, m"),
        ("node.1.join = 'node/2'", "node/1: join is 'node/2'; write ids of nodes, such as [123, 456]"),
        ("node.1.join = []", "node/1: join is []; write ids of nodes"),
        ("node.1.join = 1", "node/1: join and split name other nodes, not the node itself"),
        ("node.1 = { join = [2], split = [2] }", "node/1: join and split both name node/2; give one of them"),
        ("node.1 = { join = [2], split = true }", "node/1: join and split both name node/2; give one of them"),
        ("relation.1.keep = true", "relation/1: 'keep' is unknown; known are drop, note"),
        ("way.1.lanes 3", "is not TOML"),
    ],
)
def test_what_is_wrong_is_named_with_file_element_and_key(text: str, words: str, tmp_path: Path) -> None:
    path = write(tmp_path, text)
    with pytest.raises(InputError) as error:
        read_corrections(path)
    assert str(error.value).startswith(f"{path}")
    assert words in str(error.value)


@pytest.mark.parametrize(
    ("properties", "words"),
    [
        ([{"osm": "way/1", "lans": 3}], "feature 1: way/1: 'lans' is unknown; do you mean 'lanes'?"),
        ([{"lanes": 3}], 'feature 1: it names no element; give it a property such as "osm": "way/123"'),
        ([{"osm": "street/1", "lanes": 3}], "feature 1: it names no element"),
        ([{"osm": 12, "lanes": 3}], "feature 1: it names no element"),
        ([{"osm": "way/1", "lanes": 3}, {"osm": "way/1", "lanes": 2}], "feature 2: way/1: lanes is given twice"),
        ([{"osm": "way/1", "lanes": "3"}], "way/1: lanes is '3'; write a whole number"),
    ],
)
def test_what_is_wrong_with_features(properties: list[Any], words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=re.escape(words)):
        read_corrections(write_features(tmp_path, *properties))


@pytest.mark.parametrize(("text", "words"), [("{", "is not GeoJSON"), ("[]", "is no FeatureCollection of GeoJSON")])
def test_what_is_no_geojson(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        read_corrections(write(tmp_path, text, "known.json"))


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read: no such file or directory; check the path"):
        read_corrections(tmp_path / "none.toml")


def test_the_document_has_an_example_of_each_key_and_all_can_be_read(tmp_path: Path) -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    shown = re.findall(r"`((?:way|node|relation)\.1\.[\w-]+ = [^`]+)`", text)
    for number, line in enumerate(shown):
        read_corrections(write(tmp_path, line, f"line_{number}.toml"))
    keys = {(line.split(".")[0], line.split(".")[2].split(" ")[0]) for line in shown}
    from osm2xodr.osmParsing import CORRECTION_KEYS

    assert keys == {(kind, key) for kind, known in CORRECTION_KEYS.items() for key in known if key != "note"}
    for block in re.findall(r"```toml\n(.*?)```", text, re.DOTALL):
        assert list(read_corrections(write(tmp_path, block)).entries()) != []
