"""Manifests: what they mean, and what is said of those that mean nothing."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from osm2xodr.batching.manifest import ManifestContext, read_manifest
from osm2xodr.batching.model import Area, for_batches
from osm2xodr.cli.batch_options import area_options, check_area_options, parse_options
from osm2xodr.cli.convert import convert
from osm2xodr.errors import InputError
from osm2xodr.python_api import DECLARATIONS

BOX = ((1.5, 42.5), (1.6, 42.5), (1.6, 42.7), (1.5, 42.7))


def context(*given: str, dems: tuple[Path, ...] = ()) -> ManifestContext:
    return ManifestContext(area_options(), check_area_options, dems, given)


def read(folder: Path, text: str, name: str = "areas.toml", *given: str) -> list[Area]:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return read_manifest(path, context(*given))


def test_toml_with_defaults(tmp_path: Path) -> None:
    for name in ("b.tif", "a.tif", "own.tif"):
        (tmp_path / name).touch()
    areas = read(
        tmp_path,
        """
        [defaults]
        osm = "country.osm.pbf"
        dem = ["[ab].tif"]
        ways = "major"
        left-hand = true
        options = "--objects trees"
        [[area]]
        name = "harbour"
        bbox = [1.5, 42.5, 1.6, 42.7]
        default-lane-width = 3
        [[area]]
        name = "Old town (1)"
        osm = "sub/town.osm"
        dem = "own.tif"
        ways = "all"
        left-hand = false
        xodr-version = "1.8"
        polygon = [[1, 42], [1.5, 42], [1.2, 42.5], [1, 42]]
        """,
    )
    left = ("--ways", "major", "--left-hand", "--default-lane-width", "3.0", "--objects", "trees")
    right = ("--xodr-version", "1.8", "--ways", "all", "--objects", "trees")
    corners = ((1.0, 42.0), (1.5, 42.0), (1.2, 42.5))
    assert areas == [
        Area("harbour", tmp_path / "country.osm.pbf", (tmp_path / "a.tif", tmp_path / "b.tif"), left, (BOX,)),
        Area("Old town (1)", tmp_path / "sub/town.osm", (tmp_path / "own.tif",), right, (corners,)),
    ]


def test_csv_means_the_same(tmp_path: Path) -> None:
    (tmp_path / "a.tif").touch()
    text = (
        "\ufeffname,osm,dem,bbox,left-hand,ways,max-memory\n"
        'harbour,m.osm,a.tif; b.tif,"1.5,42.5,1.6,42.7",yes,major,2G\n'
        "\n"
        "plain,m.osm,,,no,,\n"
    )
    options = ("--ways", "major", "--left-hand", "--max-memory", "2000000000")
    assert read(tmp_path, text, "areas.csv") == [
        Area("harbour", tmp_path / "m.osm", (tmp_path / "a.tif", tmp_path / "b.tif"), options, (BOX,)),
        Area("plain", tmp_path / "m.osm"),
    ]


def test_what_is_given_for_all_yields_to_the_manifest(tmp_path: Path) -> None:
    path = tmp_path / "areas.csv"
    path.write_text("name,osm,ways,dem\none,m.osm,all,\ntwo,m.osm,,own.tif\n", encoding="utf-8")
    areas = read_manifest(path, context("--ways", "major", "--smoothing", "2", dems=(Path("all.tif"),)))
    assert [area.options for area in areas] == [
        ("--ways", "all", "--smoothing", "2.0"),
        ("--ways", "major", "--smoothing", "2.0"),
    ]
    assert [area.dems for area in areas] == [(Path("all.tif"),), (tmp_path / "own.tif",)]


def test_a_polygon_from_a_file_is_beside_the_manifest(tmp_path: Path) -> None:
    (tmp_path / "p.geojson").write_text('{"type": "Polygon", "coordinates": [[[1, 2], [3, 2], [3, 4], [1, 2]]]}')
    areas = read(tmp_path, "name,osm,polygon\na,m.osm,p.geojson\n", "areas.csv")
    assert areas[0].outline_deg == (((1.0, 2.0), (3.0, 2.0), (3.0, 4.0)),)


AREA = '[[area]]\nname = "a"\nosm = "m.osm"\n'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "lists no areas; give at least one, with a name and an osm file"),
        ("[[area]\n", "is not TOML: "),
        ("[[areas]]\n", "'areas' is unknown; do you mean 'area'?; write [defaults] and [[area]]"),
        ('[area]\nname = "a"\n', "area is not a list of tables; write [[area]], with two brackets, before each"),
        ("defaults = 3\n", "defaults is not a table; write [defaults]"),
        ('[defaults]\nname = "a"\n' + AREA, "[defaults]: name cannot be the same for all areas"),
        ('[defaults]\nway = "a"\n' + AREA, "[defaults]: 'way' is unknown; do you mean 'ways'?"),
        ("[[area]]\nosm = 'm'\n", 'area 1: it has no name; give one, such as name = "harbour"'),
        ("[[area]]\nname = 'a'\n", 'area 1 (a): it has no osm file; give one, such as osm = "area.osm.pbf"'),
        (AREA + "left_hand = true\n", "area 1 (a): 'left_hand' is unknown; do you mean 'left-hand'?"),
        (
            AREA + "zzz = 1\n",
            "area 1 (a): 'zzz' is unknown; known are name, osm, dem, bbox, polygon, options, right-hand",
        ),
        (AREA + "jobs = 2\n", "area 1 (a): 'jobs' is unknown"),
        (AREA + "left-hand = 'perhaps'\n", "left-hand is 'perhaps'; write true or false"),
        (AREA + "left-hand = 1\n", "left-hand is 1; write true or false"),
        (AREA + "ways = true\n", "ways is neither text nor a number; write it as after --ways of convert"),
        (AREA + "ways = 'dirt'\n", "area 1 (a): --ways: "),
        (AREA + "xodr-version = '3'\n", "area 1 (a): Invalid value for '--xodr-version': '3' is not one of"),
        (AREA + "left-hand = true\nright-hand = true\n", "--left-hand and --right-hand exclude each other"),
        (AREA + "options = '--jobs 2'\n", "--jobs cannot be given to areas of a batch; leave it out"),
        (AREA + "options = '-o x'\n", "--output cannot be given to areas of a batch; leave it out"),
        (AREA + "options = '--dem x'\n", "--dem cannot be given to areas of a batch; leave it out"),
        (AREA + "options = 'more.osm'\n", "more.osm: one area at a time"),
        (AREA + "options = '--wais all'\n", "convert has no option --wais; do you mean --ways?"),
        (AREA + "options = '--help'\n", "--help is not an option of areas; run osm2xodr convert --help"),
        (AREA + "options = 'a \"b'\n", "area 1 (a): options: no closing quotation; check the quotes"),
        (AREA + "options = 3\n", 'options is not text; write options = "--ways major --left-hand"'),
        (AREA + "dem = 3\n", "dem is neither a path nor a list of paths"),
        (AREA + "dem = '*.tif'\n", "area 1 (a): dem: no file is called like "),
        (AREA + "bbox = [1, 2, 3]\n", "area 1 (a): bbox is not [west, south, east, north] in degrees"),
        (AREA + "bbox = [3, 2, 1, 4]\n", "bbox is not [west, south, east, north] in degrees: 3, 2, 1, 4; put west"),
        (AREA + "bbox = [1, 2, 3, nan]\n", "bbox is not [west, south, east, north] in degrees"),
        (AREA + "bbox = [1,2,3,4]\npolygon = 'p'\n", "bbox and polygon exclude each other; give one of them"),
        (AREA + "polygon = [[1, 2], [3, 4]]\n", "polygon: a ring needs three corners or more"),
        (AREA + "polygon = [[1, 2], [3, 99], [4, 5]]\n", "polygon: 3, 99 is not a place"),
        (AREA + "polygon = 'none.geojson'\n", "area 1 (a): polygon: "),
        (AREA + AREA, "two areas are called 'a'; give each a name of its own"),
        (AREA + AREA.replace('"a"', '"A"'), "two areas are called 'A'; give each a name of its own"),
        (AREA.replace('"a"', '"a/b"'), "'a/b' cannot be the name of an area: a name cannot hold '/'"),
        (AREA.replace('"a"', '".a"'), "a name begins with neither a dot nor a dash"),
        (AREA.replace('"a"', '"-a"'), "a name begins with neither a dot nor a dash"),
        (AREA.replace('"a"', '"Index"'), "the batch has a file of this name; choose another one"),
        (AREA.replace('"a"', '""'), "a name has 1 to 120 bytes"),
        (AREA.replace('"a"', '"a\\u202e"'), "a name cannot hold "),
    ],
)
def test_errors_of_toml_name_the_place_and_the_remedy(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(str(tmp_path / "areas.toml"))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1: it names no columns; begin with a line such as name,osm,dem,bbox"),
        ("name,osm\n", "lists no areas"),
        ("name,name\n", "line 1: there are two columns 'name'; leave one out"),
        ("name,osm\na,m.osm,x\n", "line 2: it has 3 cells, and line 1 has 2; put text with commas in quotes"),
        ('name,osm\n"a,m.osm\n', "it is not CSV: "),
        ("name,osm,colour\na,m.osm,red\n", "line 2: 'colour' is unknown"),
        ("name,osm,bbox\na,m.osm,1 2 3 4\n", "line 2: bbox '1 2 3 4' is not \"west,south,east,north\" in degrees"),
        ("name,osm,left-hand\na,m.osm,maybe\n", "line 2: left-hand is 'maybe'; write true or false"),
    ],
)
def test_errors_of_csv_name_the_line(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path, text, "areas.csv")
    assert str(caught.value).startswith(str(tmp_path / "areas.csv"))
    assert words in str(caught.value)


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"is not a manifest; give a file that ends in \.toml or \.csv"):
        read(tmp_path, "", "areas.json")
    with pytest.raises(InputError, match="cannot be read: no such file or directory; check the path"):
        read_manifest(tmp_path / "none.toml", context())
    (tmp_path / "bad.csv").write_bytes(b"name\n\xff")
    with pytest.raises(InputError, match=r"is not in UTF-8 \(invalid start byte at byte 5\); save it as UTF-8"):
        read_manifest(tmp_path / "bad.csv", context())


def test_options_of_areas_are_those_of_convert_that_name_no_files() -> None:
    options = area_options()
    assert options["left-hand"] is True
    assert options["ways"] is False
    assert {"max-memory", "timeout", "target", "objects"} <= set(options)
    assert not {"jobs", "output", "dem", "report-json", "html", "check", "name", "frame", "quiet"} & set(options)


def test_options_in_order_the_last_of_each() -> None:
    words = ("--timeout", "2min", "--ways", "all", "--left-hand", "--ways", "major")
    assert check_area_options(words, False) == ("--ways", "major", "--left-hand", "--timeout", "120.0")
    assert check_area_options(check_area_options(words, False), False) == check_area_options(words, False)


# A value of each option of areas that says more than its kind, and what it needs besides.
VALUES = {
    "date": "2024-05-01",
    "ways": "major",
    "default-lane-width": "3.0",
    "vertical-datum": "EPSG:3855",
    "dem-vertical-datum": "EPSG:5773",
    "dem-crs": "EPSG:25832",
    "dem-unit": "ft",
    "max-grade": "motorway=0.05",
    "objects": "trees",
    "max-memory": "2G",
    "timeout": "2min",
}
NEEDS = {"dem-vertical-datum": {"vertical-datum": "EPSG:3855"}}


def value_of(name: str) -> str:
    declared = DECLARATIONS.get(name.replace("-", "_"))
    return VALUES.get(name) or (
        declared.choices[-1] if declared and declared.choices else "1" if declared and declared.kind is float else "3"
    )


@pytest.mark.parametrize("name", area_options())
def test_every_option_of_areas_by_manifest_options_and_config(name: str, tmp_path: Path) -> None:
    (tmp_path / "dem.tif").touch()
    flag = area_options()[name]
    bare = flag or name == "polynomial-order"
    more = NEEDS.get(name, {})
    words = tuple(word for key, value in more.items() for word in (f"--{key}", value))
    words += (f"--{name}",) if flag else (f"--{name}", value_of(name))
    expected = check_area_options(words, True)
    assert f"--{name}" in expected
    keys = {**more, name: "true" if flag else value_of(name)}
    area = '[[area]]\nname = "a"\nosm = "area.osm"\ndem = "dem.tif"\n'
    quoted = "".join(f"{key} = {value if bare and key == name else repr(value)}\n" for key, value in keys.items())
    (own,) = read(tmp_path, area + quoted)
    assert own.options == expected
    (given,) = read(tmp_path, area, "areas.toml", *words)
    assert given.options == expected
    assert parse_options(shlex.join(words)) == words
    config = tmp_path / "osm2xodr.toml"
    config.write_text(f'area = "area.osm"\ndem = "dem.tif"\n[options]\n{quoted}[outputs]\nxodr = "a.xodr"\n')
    if name in DECLARATIONS or name.replace("-", "_") in DECLARATIONS:
        by_file = convert.make_context("convert", ["--config", str(config)]).params
        by_words = convert.make_context("convert", ["area.osm", "-o", "a.xodr", *words]).params
        key = name.replace("-", "_")
        assert by_file[key] == by_words[key]


def test_options_about_elevation_models_need_one(tmp_path: Path) -> None:
    text = '[[area]]\nname = "a"\nosm = "area.osm"\ndem-sigma = 1.5\n'
    with pytest.raises(InputError, match="--dem-sigma is about elevation models; give one with --dem"):
        read(tmp_path, text)
    path = tmp_path / "areas.toml"
    (area,) = read_manifest(path, context(dems=(Path("dem.tif"),)))
    assert area.options == ("--dem-sigma", "1.5")


def test_messages_say_where_a_batch_takes_the_options_that_they_name() -> None:
    own = frozenset({"--workers", "--dem"})
    assert for_batches("use fewer --workers", own) == "use fewer --workers"
    assert for_batches("allow it with --allow-partial, or give --dem", own) == (
        "allow it with --allow-partial, or give --dem (in a batch: --allow-partial within --options, or allow-partial"
        " as a key of the manifest)"
    )
