"""Cuts are made once for as long as they would come out the same, and boxes beside the map are told of."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from batch_runs import write_table, write_village
from riverside import RIVERSIDE
from small_area import write_area

from osm2xodr import batching
from osm2xodr.batching import (
    Area,
    BatchOptions,
    Status,
    Workers,
    cutting,
    open_out_dir,
    outlined,
    run_batch,
    workflow,
)
from osm2xodr.batching.cutting import Target, write_targets
from osm2xodr.batching.cutting.source import Source
from osm2xodr.batching.model import CutRequest, Result
from osm2xodr.cli import main
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import OutputError, SwappedAxesError
from osm2xodr.osmParsing import read_surroundings

WEST = ((1.569, 42.549), (1.571, 42.549), (1.571, 42.551), (1.569, 42.551))
ALL = ((1.56, 42.54), (1.58, 42.54), (1.58, 42.56), (1.56, 42.56))
SEA = ((3.0, 42.5), (3.1, 42.5), (3.1, 42.6), (3.0, 42.6))


class Counter:
    """Notes what a batch says of its areas."""

    def __init__(self) -> None:
        self.said: list[tuple[object, ...]] = []

    def begin(self, areas: int) -> None:
        self.said.append(("begin", areas))

    def stage(self, name: str) -> None:
        pass

    def settle(self, ended: int, failed: int) -> None:
        self.said.append(("settle", ended, failed))

    def convert(self, weights: Sequence[float]) -> None:
        self.said.append(("convert", len(weights)))

    def end(self, result: Result, weight: float) -> None:
        self.said.append(("end", result.name))


class Maps:
    """A map, of which two areas have streets and one has none, and what is cut out of it."""

    def __init__(self, folder: Path, patches: pytest.MonkeyPatch) -> None:
        self.osm = write_village(folder, 0)
        self.out = folder / "out"
        self.cut: list[list[str]] = []
        self.counter = Counter()
        original = cutting.cut_areas

        def noted(
            source: Path, requests: Sequence[CutRequest], written: Callable[..., object] | None = None
        ) -> dict[str, int]:
            self.cut.append([request.name for request in requests])
            return original(source, requests, written)

        patches.setattr(cutting, "cut_areas", noted)
        # Nothing is converted: conversions are interrupted at once.
        patches.setattr(workflow, "running", self.interrupted)

    def interrupted(self, *given: object) -> object:
        raise KeyboardInterrupt

    def run(
        self,
        *options: str,
        force: bool = False,
        surroundings: bool = False,
        **rings: tuple[tuple[float, float], ...],
    ) -> list[str]:
        """Start a batch that is interrupted, and return the areas that were cut out anew."""
        found = rings or {"west": WEST, "all": ALL, "sea": SEA}
        areas = [outlined(Area(name, self.osm, (), options, (ring,))) for name, ring in found.items()]
        self.cut.clear()
        self.counter = Counter()
        how = BatchOptions(Workers(""), force=force, surroundings=surroundings)
        with pytest.raises(KeyboardInterrupt), open_out_dir(self.out) as out:
            run_batch(areas, out, how, Diagnostics(), self.counter)
        return [name for names in self.cut for name in names]

    def kept(self) -> list[str]:
        return sorted(path.name for path in (self.out / ".cuts").iterdir())


@pytest.fixture
def maps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Maps:
    return Maps(tmp_path, monkeypatch)


def test_cuts_outlive_an_interruption(maps: Maps) -> None:
    assert maps.run() == ["west", "all", "sea"]
    files = ["all.json", "all.osm.pbf", "sea.json", "west.json", "west.osm.pbf"]
    assert maps.kept() == files
    before = {name: (maps.out / ".cuts" / name).read_bytes() for name in files}
    assert maps.run() == []
    assert {name: (maps.out / ".cuts" / name).read_bytes() for name in maps.kept()} == before
    # The empty area is settled now.
    assert maps.run("--left-hand") == []


def test_cuts_are_made_anew_on_request(maps: Maps) -> None:
    maps.run()
    assert maps.run(force=True) == ["west", "all", "sea"]


def test_cuts_with_buildings_are_other_ones(maps: Maps) -> None:
    maps.run()
    assert maps.run(surroundings=True) == ["west", "all", "sea"]
    assert maps.run(surroundings=True) == []
    assert maps.run() == ["west", "all", "sea"]


@pytest.mark.parametrize(
    ("change", "anew"),
    [
        (lambda maps: write_area(maps.osm.parent, maps.osm.read_text() + " ", maps.osm.name), ["west", "all", "sea"]),
        (lambda maps: os.utime(maps.osm, ns=(1, 1)), []),
        (lambda maps: (maps.out / ".cuts/all.osm.pbf").write_bytes(b"damaged"), ["all"]),
        (lambda maps: (maps.out / ".cuts/all.osm.pbf").unlink(), ["all"]),
        (lambda maps: (maps.out / ".cuts/all.json").unlink(), ["all"]),
        (lambda maps: (maps.out / ".cuts/all.json").write_text("{"), ["all"]),
        (lambda maps: edit(maps.out / ".cuts/all.json", version="0.0"), ["all"]),
        (lambda maps: edit(maps.out / ".cuts/all.json", format=0), ["all"]),
        (lambda maps: edit(maps.out / ".cuts/all.json", ways={"other": 2}), ["all"]),
    ],
    ids=["map", "time", "damaged", "gone", "no-record", "half-record", "version", "format", "other-areas"],
)
def test_what_would_not_be_the_same_is_cut_anew(
    maps: Maps, change: Callable[[Maps], object], anew: list[str]
) -> None:
    maps.run()
    change(maps)
    assert maps.run() == anew
    assert maps.run() == []


def edit(path: Path, **values: object) -> None:
    path.write_text(json.dumps({**json.loads(path.read_text()), **values}))


def test_other_outlines_and_ways_are_cut_anew_and_what_nobody_wants_is_removed(maps: Maps) -> None:
    maps.run()
    assert maps.run(west=ALL, all=ALL) == ["west"]
    assert maps.kept() == ["all.json", "all.osm.pbf", "west.json", "west.osm.pbf"]
    assert maps.run("--ways", "all", all=ALL) == ["all"]
    assert maps.kept() == ["all.json", "all.osm.pbf"]


def test_what_is_half_cut_is_not_taken_for_whole(maps: Maps, monkeypatch: pytest.MonkeyPatch) -> None:
    """The disk is full after the first group of areas."""
    monkeypatch.setattr("osm2xodr.batching.cutting._OPEN_MAX", 1)
    original = write_targets

    def full(source: Source, targets: Sequence[Target]) -> None:
        original(source, targets)
        monkeypatch.setattr("osm2xodr.batching.cutting.write_targets", fails)

    def fails(*given: object) -> None:
        raise OutputError("the disk is full")

    monkeypatch.setattr("osm2xodr.batching.cutting.write_targets", full)
    with open_out_dir(maps.out) as out:
        areas = [outlined(Area(name, maps.osm, (), (), (ring,))) for name, ring in (("all", ALL), ("west", WEST))]
        found = run_batch(areas, out, BatchOptions(Workers("")), Diagnostics(), maps.counter)
    assert [item.status for item in found] == [Status.FAILED, Status.FAILED]
    assert maps.counter.said == [("begin", 2), ("settle", 0, 0), ("settle", 2, 2)]
    assert maps.kept() == ["all.json", "all.osm.pbf"]
    monkeypatch.setattr("osm2xodr.batching.cutting.write_targets", original)
    (maps.out / ".cuts" / "west.osm.pbf.part").touch()
    assert maps.run(all=ALL, west=WEST) == ["west"]
    assert ".part" not in " ".join(maps.kept())


def test_the_counter_counts_all_areas_from_the_start(maps: Maps) -> None:
    maps.run()
    assert maps.counter.said == [("begin", 3), ("settle", 0, 0), ("settle", 1, 0), ("convert", 2)]
    maps.run()
    # What is empty was found out before.
    assert maps.counter.said == [("begin", 3), ("settle", 1, 0), ("settle", 1, 0), ("convert", 2)]


@pytest.mark.parametrize("name", ["areas.csv", "areas.geojson"])
def test_swapped_axes_are_told_of_with_their_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    write_village(tmp_path, 0)
    if name == "areas.csv":
        rows = [{"name": "sea", "bbox": "3.0,42.5,3.1,42.6"}, {"name": "town", "bbox": "42.54,1.56,42.56,1.58"}]
        write_table(Path(name), [{**row, "osm": "village_00.osm"} for row in rows])
        words, entry = [name], "areas.csv, line 3"
    else:
        ring = [[lat, lon] for lon, lat in (*ALL, ALL[0])]
        feature = {"type": "Polygon", "coordinates": [ring]}
        Path(name).write_text(json.dumps(feature), encoding="utf-8")
        words, entry = ["--from", "village_00.osm", "--areas", name], "areas.geojson, feature 1"
    assert main(["batch", *words, "-o", "out"]) == 1
    said = capsys.readouterr().err
    assert said.startswith(
        f"osm2xodr: error: {entry}: it lies beside village_00.osm (1.57,42.55,1.574,42.55), and in"
    )
    assert "give longitudes first" in said
    assert said.count("\n") == 1


def test_swapped_axes_of_an_option_are_told_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    osm = write_village(tmp_path, 0)
    words = ["convert", str(osm), "-o", str(tmp_path / "a.xodr"), "-q", "--bbox"]
    assert main([*words, "42.54,1.56,42.56,1.58"]) == 1
    assert "error: bbox 42.54,1.56,42.56,1.58: it lies beside" in capsys.readouterr().err
    # Beside the map either way: there is just nothing.
    assert main([*words, "3.0,42.5,3.1,42.6"]) == 1
    assert "there is nothing to drive on" in capsys.readouterr().err


def test_only_what_lies_beside_the_map_is_taken_for_swapped(tmp_path: Path) -> None:
    osm = write_village(tmp_path, 0)
    item = outlined(Area("a", osm, (), (), (tuple((lat, lon) for lon, lat in ALL),)))
    assert item.frame is not None
    assert item.outline is not None
    request = CutRequest("a", tmp_path / "a.osm.pbf", item.frame, item.outline)
    with pytest.raises(SwappedAxesError, match="a: it lies beside"):
        batching.cut_areas(osm, [request])


def test_road_networks_are_the_same_with_buildings_in_cuts(tmp_path: Path) -> None:
    source, out = RIVERSIDE.write(tmp_path), tmp_path / "out"
    command = ["batch", "--from", source, "--tiles", "400m", "--shared-frame", "-o", out, "--workers", "1", "-q"]
    found = []
    for more in ([], ["--surroundings"]):
        assert main([*map(str, command), *more]) == 0
        found.append({path.name: path.read_bytes() for path in out.glob("x*.*")})
    assert len(found[0]) > 4
    assert found[0] == found[1]
    shown = {item.osm_id for cut in (out / ".cuts").glob("*.osm.pbf") for item in read_surroundings(cut).buildings}
    assert shown == {"way/10", "way/20", "way/30"}
