"""What is written about an area, and what is refused before anything is done."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from map_service import ORDINO, SAMPLE

from osm2xodr.errors import OptionError, OutputError
from osm2xodr.fetching import FetchOptions, Network, fetch_area, place_of_box
from osm2xodr.fetching.area import sources_text
from osm2xodr.fetching.elevation import FetchedModel
from osm2xodr.fetching.models import read_models

PLACE = place_of_box(",".join(map(str, ORDINO)))


def options(folder: Path, **how: Any) -> FetchOptions:
    given = {"extract": str(SAMPLE / "area.osm"), "dem": False, **how}
    return FetchOptions(folder / "out", folder / "cache", network=Network(retries=0), **given)


def test_a_map_alone(tmp_path: Path) -> None:
    area = fetch_area(PLACE, options(tmp_path))
    assert area.osm is not None
    assert area.dems == ()
    text = area.sources.read_text(encoding="utf-8")
    assert "date of the data not stated" in text
    assert "42.55000 to 42.56500 N,\n1.56000 to 1.59000 E" in text
    # Nothing is left of the work.
    assert sorted(path.name for path in (tmp_path / "cache").iterdir()) == ["lock"]


def test_the_same_bytes_each_time(tmp_path: Path) -> None:
    made = [fetch_area(PLACE, options(tmp_path / name)) for name in "ab"]
    assert made[0].osm is not None
    assert made[1].osm is not None
    assert made[0].osm.path.read_bytes() == made[1].osm.path.read_bytes()


def test_sources_name_every_model() -> None:
    for model in read_models(()).values():
        fetched = FetchedModel((Path("dem.tif"), Path("dem_2.tif")), model, ("https://a/1", "https://a/2"), 0, 0.0)
        text = sources_text(PLACE, None, [fetched])
        rows = [line for line in text.splitlines() if line.startswith("| `dem")]
        assert [row.split("`")[1] for row in rows] == ["dem.tif", "dem_2.tif"]
        for row in rows:
            assert row.count(" | ") == 3
            assert model.title in row
            assert row.endswith(f"| {model.licence} | {model.attribution} |")
        assert "- <https://a/2>" in text
        assert "OpenStreetMap" not in text


def test_signs_of_tables_do_not_break_them() -> None:
    model = replace(next(iter(read_models(()).values())), attribution="A | B")
    text = sources_text(PLACE, None, [FetchedModel((Path("dem.tif"),), model, (), 0, 0.0)])
    assert "| A \\| B |" in text


def test_outputs_are_checked_first(tmp_path: Path) -> None:
    fetch_area(PLACE, options(tmp_path))
    before = (tmp_path / "out" / "area.osm").read_bytes()
    with pytest.raises(OutputError, match=r"SOURCES.md exists; give another folder with -o, or --overwrite"):
        fetch_area(PLACE, options(tmp_path))
    fetch_area(PLACE, options(tmp_path, overwrite=True))
    assert (tmp_path / "out" / "area.osm").read_bytes() == before
    own = str(tmp_path / "out" / "area.osm")
    with pytest.raises(OptionError, match=r"extract .*area.osm would be replaced; choose another folder for output"):
        fetch_area(PLACE, options(tmp_path, overwrite=True, extract=own))
    assert (tmp_path / "out" / "area.osm").read_bytes() == before


def test_folders_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    for how in (
        {"out_dir": tmp_path / "file"},
        {"cache_dir": tmp_path / "file"},
        {"out_dir": tmp_path / "file" / "x"},
    ):
        given: dict[str, Any] = {"out_dir": tmp_path / "out", "cache_dir": tmp_path / "cache", **how}
        with pytest.raises(OutputError, match=r"where a folder should be|not a directory"):
            fetch_area(PLACE, FetchOptions(extract=str(SAMPLE / "area.osm"), dem=False, **given))


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"osm": False, "dem": False}, "no_osm and no_dem leave nothing to fetch; give one of them"),
        ({"osm": False, "dem": True}, "no_osm and extract exclude each other; give one of them"),
        (
            {"dem": True, "models": ("a", "b"), "model_url": "http://x"},
            "dem_url is for one elevation model; give one",
        ),
    ],
)
def test_options_that_contradict_each_other(tmp_path: Path, how: dict[str, Any], message: str) -> None:
    with pytest.raises(OptionError, match=message):
        options(tmp_path, **how)
