"""Where traffic can go in the sound T junction."""

from __future__ import annotations

from pathlib import Path

from t_junction import sound_map
from xodr_text import read_text

from osm2xodr.checking import driving_of
from osm2xodr.opendrive.tables import OpenDrive


def names(file: OpenDrive, nodes: list[int]) -> list[str]:
    """Return nodes as road, index of the section on it, lane and direction."""
    out = []
    for node in nodes:
        row, section = node // 2, int(file.lanes.section[node // 2])
        road = int(file.sections.road[section])
        number = section - int(file.sections.start[road])
        out.append(f"{file.roads.id[road]}.{number}:{file.lanes.id[row]}{'-' if node % 2 else '+'}")
    return out


def test_steps_follow_traffic(tmp_path: Path) -> None:
    file = read_text(tmp_path, sound_map())
    graph = driving_of(file)
    found = set(zip(names(file, graph.start.tolist()), names(file, graph.end.tolist()), strict=True))
    assert found == {
        # Through the junction: right-hand lanes run along s, left-hand ones against it.
        ("1.0:-1+", "10.0:-1+"),
        ("10.0:-1+", "2.0:-1+"),
        ("2.0:1-", "11.0:-1+"),
        ("11.0:-1+", "1.0:1-"),
        ("1.0:-1+", "12.0:-1+"),
        ("12.0:-1+", "3.0:1-"),
        ("3.0:-1+", "13.0:-1+"),
        ("13.0:-1+", "2.0:-1+"),
        ("3.0:-1+", "14.0:-1+"),
        ("14.0:-1+", "1.0:1-"),
        ("2.0:1-", "15.0:-1+"),
        ("15.0:-1+", "3.0:1-"),
        # From section to section, and from road to road.
        ("2.0:-1+", "2.1:-1+"),
        ("2.1:1-", "2.0:1-"),
        ("2.1:-1+", "4.0:-1+"),
        ("4.0:1-", "2.1:1-"),
    }
    # Each lane but the centre ones has one direction.
    assert (graph.along != graph.against).sum() == (file.lanes.id != 0).sum()
    assert not (graph.along & graph.against).any()


def test_left_hand_traffic_runs_the_other_way(tmp_path: Path) -> None:
    file = read_text(tmp_path, sound_map().replace('rule="RHT"', 'rule="LHT"'))
    graph = driving_of(file)
    found = set(zip(names(file, graph.start.tolist()), names(file, graph.end.tolist()), strict=True))
    assert ("2.0:1+", "2.1:1+") in found
    assert ("2.1:-1-", "2.0:-1-") in found
