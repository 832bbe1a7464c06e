"""The options about furniture, from the command line to the file."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from lxml import etree

from osm2xodr.cli import main

# A main road with lights and a crossing, sidewalks and a lamp; a tree stands beside it.
MAP = """<?xml version='1.0' encoding='UTF-8'?>
<osm version='0.6'>
<node id='1' lat='48.0' lon='11.0'><tag k='highway' v='traffic_signals'/></node>
<node id='2' lat='48.001' lon='11.0'/>
<node id='3' lat='48.0' lon='11.0015'/>
<node id='4' lat='47.999' lon='11.0'/>
<node id='5' lat='48.0005' lon='11.0'><tag k='highway' v='crossing'/></node>
<node id='6' lat='48.0006' lon='11.0001'><tag k='natural' v='tree'/></node>
<node id='7' lat='48.0007' lon='11.0001'><tag k='highway' v='street_lamp'/></node>
<way id='1'><nd ref='4'/><nd ref='1'/><nd ref='5'/><nd ref='2'/><tag k='highway' v='secondary'/>
<tag k='sidewalk' v='both'/><tag k='parking:left' v='lane'/></way>
<way id='2'><nd ref='1'/><nd ref='3'/><tag k='highway' v='residential'/><tag k='sidewalk' v='both'/></way>
</osm>
"""


def counted(tmp_path: Path, *options: str) -> Counter[str]:
    """Convert the map; return how many lanes and objects of each type there are, signals and references."""
    area, out = tmp_path / "area.osm", tmp_path / "area.xodr"
    area.write_text(MAP, encoding="utf-8")
    assert main(["convert", str(area), "-o", str(out), "-q", "--overwrite", *options]) == 0
    tree = etree.parse(out)
    found = Counter(str(item.get("type")) for item in tree.iter("lane", "object"))
    found.update(str(item.tag) for item in tree.iter("signal", "signalReference", "controller", "crosswalk"))
    return found


def test_everything_but_lamps_and_trees_by_default(tmp_path: Path) -> None:
    found = counted(tmp_path)
    assert found["crosswalk"] == 1
    # Six at the road ends' sides, and one for each corner and the straight side of the T. Nobody parks on the
    # crossing: its road has two sections more.
    assert found["sidewalk"] == 9 + 2 * 2
    assert (found["parking"], found["restricted"]) == (3, 1)
    assert found["signal"] >= 3
    assert found["signalReference"] >= 6
    assert found["controller"] >= 2
    assert not found["tree"] + found["streetLamp"]


@pytest.mark.parametrize(
    ("wanted", "trees", "lamps"), [("trees", 1, 0), ("lamps", 0, 1), ("lamps,trees", 1, 1), ("all", 1, 1)]
)
def test_objects_on_request(tmp_path: Path, wanted: str, trees: int, lamps: int) -> None:
    found = counted(tmp_path, "--objects", wanted)
    assert (found["tree"], found["streetLamp"]) == (trees, lamps)


def test_the_carriageway_alone(tmp_path: Path) -> None:
    found = counted(tmp_path, "--no-furniture")
    assert set(found) == {"none", "driving"}


def test_what_a_target_wants(tmp_path: Path) -> None:
    found = counted(tmp_path, "--target", "sumo")
    # Both parking lanes, cut in two where nobody parks, and the pavement between them on the closed side of the T
    assert (found["parking"], found["shoulder"], found["signalReference"]) == (0, 5, 0)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), []),
        (("--target", "sumo"), ["--opendrive.internal-shapes"]),
        (("--target", "sumo", "--left-hand"), ["--lefthand"]),
        (("--target", "sumo", "-q"), []),
    ],
)
def test_the_command_that_loads_the_file_is_said_last(
    options: tuple[str, ...],
    said: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("area.osm").write_text(MAP, encoding="utf-8")
    assert main(["convert", "area.osm", "-o", "my map.xodr", *options]) == 0
    lines = capsys.readouterr().err.splitlines()
    files = "--opendrive-files 'my map.xodr' --tllogic-files 'my map.tll.xml' -o 'my map.net.xml'"
    commands = [f"osm2xodr: load it with: netconvert {text} --junctions.endpoint-shape {files}" for text in said]
    assert [line for line in lines if "netconvert" in line] == commands
    assert not said or "netconvert" in lines[-1]


def test_signal_programmes_are_written_beside_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    area, beside = tmp_path / "area.osm", tmp_path / "x.tll.xml"
    area.write_text(MAP, encoding="utf-8")
    command = ["convert", str(area), "-o", str(tmp_path / "x.xodr"), "-q"]
    assert main(command) == 0
    assert not beside.exists()
    beside.write_text("mine", encoding="utf-8")
    assert main([*command, "--overwrite", "--target", "sumo", "--no-furniture"]) == 0
    assert beside.read_text(encoding="utf-8") == "mine"
    (tmp_path / "x.xodr").unlink()
    assert main([*command, "--target", "sumo"]) == 2
    assert "x.tll.xml exists" in capsys.readouterr().err
    assert main([*command, "--overwrite", "--target", "sumo"]) == 0
    assert "<tlLogic " in beside.read_text(encoding="utf-8")
    # They do not stay beside a file that they do not belong to.
    assert main([*command, "--overwrite"]) == 0
    assert not beside.exists()


def test_unknown_objects_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    area = tmp_path / "area.osm"
    area.write_text(MAP, encoding="utf-8")
    assert main(["convert", str(area), "-o", str(tmp_path / "x.xodr"), "--objects", "houses"]) == 2
    assert "--objects: 'houses' is not a kind of object; choose from lamps, trees, or all" in capsys.readouterr().err
