"""The folder for SUMO: its network, its traffic, and a run to the end."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from lxml import etree
from osm_builder import Area
from real_readers import run_sumo
from scene_files import SAMPLES, scene_named

import osm2xodr
from osm2xodr import InputError, Started
from osm2xodr.starting.sumo import read_network

(SAMPLE,) = SAMPLES


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory) -> Started:
    return osm2xodr.start("sumo", SAMPLE.osm, tmp_path_factory.mktemp("start") / "sumo", SAMPLE.dem)


def drive(started: Started, *options: str) -> dict[str, str]:
    """Run a folder to the end, without a window, and return SUMO's figures about vehicles and what went wrong."""
    (program, option, configuration) = started.command.split()
    assert (program, option) == ("sumo-gui", "-c")
    figures = started.folder.parent / "figures.xml"
    done = run_sumo("sumo", "-c", configuration, "--statistic-output", figures, "--end", "7200", *options)
    assert done.returncode == 0, done.stderr
    assert "Error" not in done.stderr
    root = etree.parse(str(figures)).getroot()
    return {
        f"{name} {key!s}": str(value)
        for name in ("vehicles", "teleports", "safety")
        for item in root.iterfind(name)
        for key, value in item.attrib.items()
    }


def test_all_cars_arrive(sample: Started) -> None:
    figures = drive(sample, "--collision.check-junctions", "--collision.mingap-factor", "0")
    assert int(figures["vehicles inserted"]) == int(figures["vehicles loaded"]) > 150
    assert figures["vehicles running"] == figures["vehicles waiting"] == "0"
    assert figures["teleports total"] == figures["safety collisions"] == "0"


def test_streets_keep_their_names(sample: Started) -> None:
    roads = etree.parse(str(sample.folder / "map.xodr")).getroot().findall("road")
    names = {str(road.get("id")): road.get("name", "") for road in roads}
    network = etree.parse(str(sample.folder / "map.net.xml")).getroot()
    edges = [edge for edge in network.iterfind("edge") if edge.get("function") is None]
    assert len(edges) > 300
    for edge in edges:
        assert edge.get("name", "") == names[str(edge.get("id")).lstrip("-").split("#")[0]]
    assert "Carretera Coll d'Ordino" in {edge.get("name") for edge in edges}


def test_main_roads_bring_most_of_the_traffic(sample: Started) -> None:
    """CG-2 is a primary road that comes into the area twice, the road to the Coll d'Ordino a secondary one."""
    network = etree.parse(str(sample.folder / "map.net.xml")).getroot()
    names = {str(edge.get("id")): edge.get("name", "") for edge in network.iterfind("edge")}
    trips = etree.parse(str(sample.folder / "map.rou.xml")).getroot().findall("trip")
    counts = Counter(str(trip.get("from")) for trip in trips)
    (first, second, third) = counts.most_common(3)
    # In a quarter of an hour: 7,000 and 3,000 vehicles a day, half of them this way, within 16 hours.
    assert [names[edge] for edge, _ in (first, second, third)] == ["CG-2", "CG-2", "Carretera Coll d'Ordino"]
    assert [count for _, count in (first, second, third)] == pytest.approx([54.7, 54.7, 23.4], abs=2.0)
    # All other streets have a few.
    assert len(counts) > 60
    departures = [float(trip.get("depart", "")) for trip in trips]
    assert departures == sorted(departures)
    assert 890.0 < departures[-1] < 900.0


def test_no_clock_and_no_path_of_the_machine_in_it(sample: Started, tmp_path: Path) -> None:
    again = osm2xodr.start("sumo", SAMPLE.osm, tmp_path / "again", SAMPLE.dem)
    assert [path.name for path in again.files] == [path.name for path in sample.files]
    for one, other in zip(sample.files, again.files, strict=True):
        assert one.read_bytes() == other.read_bytes(), one.name
        assert str(sample.folder.parent).encode() not in one.read_bytes()


@pytest.mark.parametrize("name", ["fremantle_placement", "i5_exit_ramp"])
def test_lights_and_both_sides_of_the_road(name: str, tmp_path: Path) -> None:
    scene = scene_named(name)
    started = osm2xodr.start("sumo", scene.osm, tmp_path / "sumo", scene.dem)
    assert started.folder / "map.tll.xml" in started.files
    network = etree.parse(str(started.folder / "map.net.xml")).getroot()
    wanted = etree.parse(str(started.folder / "map.tll.xml")).getroot()
    lights = {item.get("id") for item in wanted.iterfind("tlLogic")}
    assert lights
    assert lights <= {item.get("id") for item in network.iterfind("tlLogic")}
    assert (network.get("lefthand") == "true") == (name == "fremantle_placement")
    figures = drive(started)
    assert figures["vehicles inserted"] == figures["vehicles loaded"]
    assert figures["vehicles running"] == figures["teleports total"] == figures["safety collisions"] == "0"


def test_entrances_and_exits_are_where_nobody_comes_from_or_goes_on_to(tmp_path: Path) -> None:
    """A street of two pieces, 1 and 2, and a one-way street 3 out of it."""
    edges = {"-1": "ab", "-2": "bc", "2": "cb", "1": "ba", "-3": "bd"}
    links = [("-1", "-2"), ("-1", "-3"), ("2", "1"), ("2", "-3"), ("-2", "2"), ("1", "-1")]
    lane = '<lane id="l" index="0" speed="13.89" length="50" shape=""/>'
    rows = [f'<edge id="{name}" from="{ends[0]}" to="{ends[1]}">{lane}</edge>' for name, ends in edges.items()]
    rows += [f'<connection from="{a}" to="{b}" fromLane="0" toLane="0"/>' for a, b in links]
    for_feet = '<edge id="4" from="a" to="d"><lane id="x" allow="pedestrian" speed="1" length="9"/></edge>'
    (tmp_path / "net.xml").write_text(f"<net>{for_feet}{''.join(rows)}</net>", encoding="utf-8")
    network = read_network(tmp_path / "net.xml")
    assert network.id == tuple(edges)
    assert [name for name, so in zip(network.id, network.entrances, strict=True) if so] == ["-1", "2"]
    assert [name for name, so in zip(network.id, network.exits, strict=True) if so] == ["-2", "1", "-3"]


def test_the_smallest_of_areas_has_traffic(tmp_path: Path) -> None:
    """A one-way street, from whose only edge none leads on."""
    tags = "highway=residential oneway=yes"
    osm = Area({1: (0.0, 0.0), 2: (80.0, 0.0)}, {10: ([1, 2], tags)}).write(tmp_path)
    started = osm2xodr.start("sumo", osm, tmp_path / "sumo")
    figures = drive(started)
    assert figures["vehicles inserted"] == "60"
    assert figures["vehicles running"] == figures["teleports total"] == "0"


def test_without_sumo_it_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("SUMO_HOME", str(tmp_path))
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    scene = scene_named("i5_exit_ramp")
    with pytest.raises(InputError, match=r"netconvert.*pip install eclipse-sumo"):
        osm2xodr.start("sumo", scene.osm, tmp_path / "sumo")
    assert not (tmp_path / "sumo").exists()
    assert list(tmp_path.iterdir()) == []
