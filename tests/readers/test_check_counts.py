"""What `check` counts in files of other converters is what a slow count link by link finds."""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from real_readers import need, run_reader
from scene_files import SMALL_SCENES, Conversions, Scene, scene_named
from slow_check import slow_counts
from t_junction import sound_map

from osm2xodr.checking import CheckOptions, CheckResult, Severity, check_file

# What the slow count calls broken references.
BROKEN = (
    "road-link",
    "junction-link",
    "link-not-returned",
    "lane-link",
    "incoming-road",
    "connecting-road",
    "incoming-elsewhere",
    "connection-without-lanes",
    "connection-lane",
)
COUNTED = (
    "record-gap",
    "record-kink",
    "record-length",
    "height-step",
    "grade-step",
    "lane-gap",
    "lane-edge-gap",
    "lane-height-step",
    "link-kink",
    "link-grade-step",
)
AGREEMENT = 0.02

_OSM2ODR = """
import gzip, sys, carla
settings = carla.Osm2OdrSettings()
settings.proj_string = "+proj=tmerc"
settings.center_map = True
text = carla.Osm2Odr.convert(gzip.open(sys.argv[1], "rt", encoding="utf-8").read(), settings)
open(sys.argv[2], "w", encoding="utf-8").write(text)
"""


def by_netconvert(scene: Scene, target: Path) -> None:
    """Convert a scene by SUMO, with the elevation model."""
    need("sumo", "SUMO (eclipse-sumo)")
    spec = importlib.util.find_spec("sumo")
    assert spec is not None
    assert spec.origin is not None
    home = Path(spec.origin).parent
    command = [str(home / "bin" / "netconvert"), "--osm-files", str(scene.osm), "--opendrive-output", str(target)]
    command += ["--geometry.remove", "--junctions.join", "--osm.turn-lanes", "--proj.utm"]
    command += ["--heightmap.geotiff", str(scene.dem), "-o", os.devnull]
    done = run_reader(command, env={**os.environ, "SUMO_HOME": str(home), "PROJ_DATA": str(home / "data" / "proj")})
    assert done.returncode == 0, done.stderr


def by_carla(scene: Scene, target: Path) -> None:
    """Convert a scene by CARLA's Osm2Odr."""
    need("carla", "the CARLA client (carla)")
    done = run_reader([sys.executable, "-c", _OSM2ODR, str(scene.osm), str(target)])
    assert done.returncode == 0, done.stderr


def counts(result: CheckResult) -> dict[str, int]:
    """Return what was found, as the slow count names it."""
    found = result.by_rule()
    out = {rule: found[rule] for rule in COUNTED if rule in found}
    broken = sum(found.get(rule, 0) for rule in BROKEN)
    return {**out, "broken-references": broken} if broken else out


@pytest.mark.parametrize("converter", [by_netconvert, by_carla], ids=["SUMO", "CARLA"])
@pytest.mark.parametrize("scene", SMALL_SCENES, ids=str)
def test_counts_agree(scene: Scene, converter: Callable[[Scene, Path], None], tmp_path: Path) -> None:
    path = tmp_path / "other.xodr"
    converter(scene, path)
    found, slow = counts(check_file(path, CheckOptions(ignore=("schema",)))), slow_counts(path)
    assert set(found) == set(slow)
    assert found == {rule: pytest.approx(slow[rule], rel=AGREEMENT) for rule in slow}
    # Both converters leave gaps and lengths that are not those of the curves.
    assert slow["lane-gap"] > 0
    assert slow["record-length"] > 0


def test_the_slow_count_finds_nothing_in_a_sound_file(tmp_path: Path) -> None:
    path = tmp_path / "sound.xodr"
    path.write_text(sound_map(), encoding="utf-8")
    assert slow_counts(path) == {}


def test_the_slow_count_sees_damage(tmp_path: Path) -> None:
    path = tmp_path / "bad.xodr"
    text = sound_map().replace('x="60.0" y="0.0"', 'x="60.0" y="0.5"').replace('elementId="4"', 'elementId="5"')
    path.write_text(text, encoding="utf-8")
    found = slow_counts(path)
    # The two lanes of road 4 name those of road 2, which names a road that is not there; neither link is returned.
    assert found == {"lane-gap": 2, "lane-edge-gap": 2, "broken-references": 2}
    assert counts(check_file(path, CheckOptions(ignore=("schema",)))) == found


# ---------------------------------------------------------------- our own files

# A bridge of 23 m above a tunnel, in a model of 90 m: more clearance would make the roads too steep. Cars that turn
# back at forks of steep arms drive over both, 0.15 m off their surfaces.
KNOWN = {"andorra_ordino": {"overlap": 1, "clearance": 1, "junction-surface": 4}}


@pytest.mark.parametrize("scene", [*SMALL_SCENES, scene_named("andorra_ordino")], ids=str)
def test_our_own_files_are_clean(scene: Scene, conversions: Conversions) -> None:
    result = check_file(conversions.of(scene).path)
    assert result.notes == ()
    serious = {item.rule: item.findings for item in result.counts if item.severity > Severity.INFO}
    known = KNOWN.get(scene.name, {})
    assert {rule: n for rule, n in serious.items() if n > known.get(rule, 0)} == {}, "\n".join(result.lines())
    assert [item for item in result.findings if item.severity is Severity.ERROR] == []


def test_the_worst_of_many_findings_are_those_of_a_check_that_lists_few(conversions: Conversions) -> None:
    path = conversions.of(scene_named("andorra_ordino")).path
    many, few = check_file(path, CheckOptions(most=500)), check_file(path, CheckOptions(most=3))
    assert len(many.findings) > len(few.findings) > 3
    assert many.worst(3) == few
