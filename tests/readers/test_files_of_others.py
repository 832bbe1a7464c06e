"""Our reader takes in what other converters write: SUMO's netconvert and CARLA's Osm2Odr."""

from __future__ import annotations

import gzip
import importlib.util
import os
import sys
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from real_readers import need, run_reader
from scene_files import scene_named

import osm2xodr
from osm2xodr.opendrive.reader import read_xodr
from osm2xodr.opendrive.space import RoadFinder, lane_borders, pose, record_lengths, surface_points
from osm2xodr.opendrive.tables import ABSENT, OpenDrive, Shape

WRITERS = ("netconvert", "Osm2Odr")
OSM2ODR = "import carla, sys; a, b = sys.argv[1:]; open(b, 'w').write(carla.Osm2Odr.convert(open(a).read()))"


def converted(writer: str, folder: Path) -> Path:
    osm, path = folder / "area.osm", folder / f"{writer}.xodr"
    osm.write_bytes(gzip.decompress(scene_named("i5_exit_ramp").osm.read_bytes()))
    if writer == "Osm2Odr":
        need("carla", "the CARLA client (carla)")
        run_reader([sys.executable, "-c", OSM2ODR, str(osm), str(path)])
    else:
        need("sumo", "SUMO (eclipse-sumo)")
        spec = importlib.util.find_spec("sumo")
        assert spec is not None
        assert spec.origin is not None
        home = Path(spec.origin).parent
        command = [str(home / "bin" / "netconvert"), "--osm-files", str(osm), "--opendrive-output", str(path)]
        run_reader(command, env={**os.environ, "SUMO_HOME": str(home), "PROJ_DATA": str(home / "data" / "proj")})
    return path


@pytest.fixture(scope="module", params=WRITERS)
def written(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, OpenDrive]:
    path = converted(request.param, tmp_path_factory.mktemp("others"))
    return path, read_xodr(path)


def test_everything_is_there(written: tuple[Path, OpenDrive]) -> None:
    path, file = written
    root = etree.parse(str(path)).getroot()
    assert file.misfits == ()
    assert file.roads.id == tuple(item.get("id") for item in root.findall("road"))
    assert len(file.roads.id) > 50
    counts = {
        "road/planView/geometry": len(file.plan_view.s),
        "road/lanes/laneSection": len(file.sections.s),
        "road/lanes/laneSection/*/lane": len(file.lanes.id),
        "road/lanes/laneSection/*/lane/width": len(file.lanes.width.s),
        "road/elevationProfile/elevation": len(file.elevation.s),
        "road/signals/signal": sum(item.kind == "signal" for item in file.furniture),
        "road/objects/object": sum(item.kind == "object" for item in file.furniture),
        "junction/connection": len(file.connections.id),
        "junction/connection/laneLink": len(file.connections.link_from),
    }
    assert counts == {place: len(root.findall(place)) for place in counts}
    assert (file.connections.incoming != ABSENT).all()
    assert (file.connections.connecting != ABSENT).all()


def test_polynomials_are_read_as_they_are_meant(written: tuple[Path, OpenDrive]) -> None:
    """Most records end where the next begins, as their writer meant them to."""
    _, file = written
    plan = file.plan_view
    assert Shape.PARAM_POLY3 in plan.shape
    follows = np.flatnonzero(np.diff(np.repeat(np.arange(len(file.roads.id)), np.diff(plan.start))) == 0)
    road = np.searchsorted(plan.start, follows, side="right") - 1
    x, y, _ = pose(file, road, plan.s[follows + 1], before=True)
    gap = np.hypot(x - plan.x[follows + 1], y - plan.y[follows + 1])
    assert np.mean(gap < 1e-3) > 0.95
    np.testing.assert_allclose(np.median(record_lengths(file) / plan.length), 1.0, atol=1e-6)


def test_places_on_lanes_are_found_again(written: tuple[Path, OpenDrive]) -> None:
    """Not all: where their lanes fold over themselves or roads have kinks, a place has two pairs of coordinates."""
    _, file = written
    lanes = np.flatnonzero(file.lanes.id != 0)
    section = file.lanes.section[lanes]
    road = file.sections.road[section]
    s = 0.5 * (file.sections.s[section] + file.sections.end[section])
    inner, outer = lane_borders(file, lanes, s)
    t = 0.5 * (inner + outer)
    x, y, _ = surface_points(file, road, s, t)
    places = RoadFinder(file).find(x, y)
    same = (places.road == road[places.point]) & places.inside
    off = np.hypot(places.s - s[places.point], places.t - t[places.point])
    again = np.zeros(len(lanes), np.bool_)
    again[places.point[same & (off < 1e-3)]] = True
    assert again.mean() > 0.97
    np.testing.assert_allclose(
        np.column_stack(surface_points(file, places.road, places.s, places.t)[:2])[places.inside],
        np.column_stack([x, y])[places.point][places.inside],
        atol=0.05,
    )


def test_nouns_of_what_others_write(written: tuple[Path, OpenDrive]) -> None:
    path, file = written
    network = osm2xodr.read(path)
    assert len(network.roads) == len(file.roads.id)
    for road in network.roads:
        middle = road.length / 2.0
        assert road.lanes(middle) != ()
        assert np.isfinite([road.height(middle), *road.point(middle)]).all()
    lanes = network.to_geodataframe()
    assert lanes.crs is not None
    assert lanes.speed_kmh.notna().any()
    graph = network.to_networkx()
    assert len(graph) > 100
    assert graph.number_of_edges() > 100
