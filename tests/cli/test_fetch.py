"""The command ``fetch`` against a server on this machine, up to the conversion of what it has written."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
import rasterio
from lxml import etree
from map_service import ORDINO, OSM_BASE, SAMPLE, Overpass, height, template, tile_of, tile_path
from web_server import PAGE, Reply, WebServer, web_server, write_certificate

import osm2xodr
from osm2xodr.cli import main

BBOX = ",".join(map(str, ORDINO))


@pytest.fixture(scope="module")
def tile() -> bytes:
    return tile_of(1, 42)


@pytest.fixture
def server(tile: bytes) -> Iterator[WebServer]:
    with web_server() as made:
        made.serve("/api/interpreter", Overpass())
        made.serve_file(tile_path(1, 42), tile)
        yield made


def words(server: WebServer, folder: Path, *more: str) -> list[str]:
    where = ["--overpass", f"{server.url}/api/interpreter", "--dem-url", template(server)]
    return ["fetch", "--bbox", BBOX, "-o", str(folder / "out"), "--cache", str(folder / "cache"), *where, *more]


def error_of(capsys: pytest.CaptureFixture[str], *command: str, status: int = 1) -> str:
    """Return the last line of what a command says that must fail; it is one sentence."""
    assert main(command) == status
    said = capsys.readouterr().err.splitlines()
    assert "Traceback" not in "".join(said)
    return said[-1]


def test_fetch_and_convert_from_python(server: WebServer, tmp_path: Path) -> None:
    said: list[str] = []
    found = osm2xodr.fetch(
        tmp_path / "own",
        bbox=[float(word) for word in BBOX.split(",")],
        cache=tmp_path / "cache",
        overpass=f"{server.url}/api/interpreter",
        dem_url=template(server),
        progress=lambda task, state="", share=None: said.append(task),
    )
    assert said != []
    assert main(words(server, tmp_path)) == 0
    for name in ("area.osm", "dem.tif"):
        assert (tmp_path / "own" / name).read_bytes() == (tmp_path / "out" / name).read_bytes()
    assert found.osm is not None
    assert len(osm2xodr.convert(found.osm.path, found.dems).roads) > 70
    with pytest.raises(osm2xodr.OptionError, match="bbox and place exclude each other"):
        osm2xodr.fetch(tmp_path, bbox=BBOX, place="Ordino")
    if TYPE_CHECKING:
        osm2xodr.fetch(tmp_path, boox=BBOX)  # type: ignore[call-arg]


def test_fetch_then_convert(server: WebServer, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words(server, tmp_path)) == 0
    out = tmp_path / "out"
    said = capsys.readouterr().err.splitlines()
    assert sorted(path.name for path in out.iterdir()) == ["SOURCES.md", "area.osm", "dem.tif"]
    assert said[0].startswith(f"osm2xodr: wrote {out}/area.osm (")
    assert f"data of {OSM_BASE}" in said[0]
    command = said[-1].removeprefix("osm2xodr: go on with: osm2xodr ").split()
    assert command == ["convert", f"{out}/area.osm", "--dem", f"{out}/dem.tif", "-o", f"{out}/area.xodr"]
    assert main(command) == 0
    roads = etree.parse(out / "area.xodr").findall("road")
    assert len(roads) > 70
    assert server.most_at_once == 1
    assert {request.headers["User-Agent"].split("/")[0] for request in server.requests} == {"osm2xodr"}
    # Only a part of the tile was sent, and the heights are those of the terrain.
    sent = [request.headers.get("Range") for request in server.asked(tile_path(1, 42)) if request.method == "GET"]
    assert None not in sent
    with rasterio.open(out / "dem.tif") as dem:
        rows, cols = np.indices(dem.shape)
        lon = dem.transform.c + dem.transform.a * (cols + 0.5)
        lat = dem.transform.f + dem.transform.e * (rows + 0.5)
        np.testing.assert_array_equal(dem.read(1), height(lon, lat))
        assert dem.bounds.left < ORDINO[0] - 0.001
        assert dem.bounds.right > ORDINO[2] + 0.001
        assert "EGM2008" in dem.crs.to_wkt()
    text = (out / "SOURCES.md").read_text(encoding="utf-8")
    assert "© OpenStreetMap contributors" in text
    assert "Airbus Defence and Space" in text
    assert f"data of {OSM_BASE}" in text
    assert tile_path(1, 42) in text


def test_a_place_by_its_name(server: WebServer, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    west, south, east, north = ORDINO
    found = {"display_name": "Ordino, Andorra", "osm_type": "relation", "osm_id": 9, "category": "boundary"}
    server.serve("/search", Reply(json.dumps([{**found, "boundingbox": [south, north, west, east]}]).encode()))
    command = [*words(server, tmp_path), "--geocoder", f"{server.url}/search"]
    command[1:3] = ["--place", "Ordino, Andorra"]
    assert main(command) == 0
    said = capsys.readouterr().err
    assert f"osm2xodr: 'Ordino, Andorra' is Ordino, Andorra (boundary relation 9): --bbox {BBOX}\n" in said
    text = (tmp_path / "out" / "SOURCES.md").read_text(encoding="utf-8")
    assert "for Ordino, Andorra (boundary relation 9), found by 127.0.0.1:" in text
    assert len(server.asked("/search")) == 1
    # A file is one, also where it is missing.
    command[2] = str(tmp_path / "none.geojson")
    assert "none.geojson" in error_of(capsys, *command)
    assert len(server.asked("/search")) == 1


def test_the_dem_reaches_as_far_as_the_roads(server: WebServer, tmp_path: Path) -> None:
    assert main(words(server, tmp_path)) == 0
    tree = etree.parse(tmp_path / "out" / "area.osm")
    ways = [way for way in tree.iter("way") if way.xpath("tag[@k='highway'][@v='secondary' or @v='residential']")]
    refs = {ref.get("ref") for way in ways for ref in way.iter("nd")}
    lon = [float(node.get("lon") or "") for node in tree.iter("node") if node.get("id") in refs]
    with rasterio.open(tmp_path / "out" / "dem.tif") as dem:
        assert dem.bounds.left < min(lon) < ORDINO[0]
        assert dem.bounds.right > max(lon)


def test_a_second_fetch_asks_for_nothing(server: WebServer, tmp_path: Path) -> None:
    assert main(words(server, tmp_path)) == 0
    first = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    server.requests.clear()
    assert main(words(server, tmp_path, "--overwrite")) == 0
    assert server.requests == []
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == first
    assert main(words(server, tmp_path, "--overwrite", "--refresh")) == 0
    assert len(server.asked("/api/interpreter")) == 2


def test_it_goes_on_where_it_ended(
    server: WebServer, tile: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    server.serve(tile_path(1, 42), Reply(PAGE, 500))
    said = error_of(capsys, *words(server, tmp_path, "--retries", "0"))
    assert "has an error (status 500)" in said
    assert "--dem-url" in said
    # No file looks whole that is not: there is the map alone.
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["area.osm"]
    server.serve_file(tile_path(1, 42), tile)
    before = len(server.asked("/api/interpreter"))
    assert main(words(server, tmp_path, "--overwrite")) == 0
    assert len(server.asked("/api/interpreter")) == before


def test_a_local_extract_needs_no_network(tmp_path: Path) -> None:
    command = ["fetch", "--bbox", BBOX, "-o", str(tmp_path / "out"), "--cache", str(tmp_path / "cache"), "--no-dem"]
    assert main([*command, "--extract", str(SAMPLE / "area.osm"), "--pbf"]) == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["SOURCES.md", "area.osm.pbf"]
    assert main(["convert", str(tmp_path / "out" / "area.osm.pbf"), "-o", str(tmp_path / "a.xodr")]) == 0
    assert len(etree.parse(tmp_path / "a.xodr").findall("road")) > 70


def test_buildings_are_left_out_on_request(tmp_path: Path) -> None:
    extract = ["--extract", str(SAMPLE / "area.osm"), "--no-dem"]
    found = []
    for name, more in (("a", []), ("b", ["--no-surroundings"])):
        assert main(["fetch", "--bbox", BBOX, "-o", str(tmp_path / name), *extract, *more]) == 0
        found.append((tmp_path / name / "area.osm").read_text(encoding="utf-8").count('k="building"'))
    assert found == [30, 0]


def test_wrong_usage(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ["-o", str(tmp_path / "out")]
    cases = [
        (["--bbox", BBOX], "Missing option '-o' / '--output'."),
        (out, "no area is given; give --bbox W,S,E,N in degrees, or --place NAME|FILE"),
        (["--place", " ", *out], "no area is given; give --bbox"),
        (["--place", "Ordino", "--geocoder", "file:///x", *out], "--geocoder file:///x is no address"),
        (["--bbox", BBOX, "--place", "x", *out], "--bbox and --place exclude each other; give one of them"),
        (["--bbox", "1,2,3", *out], "--bbox 1,2,3 is not 4 numbers; write west,south,east,north in degrees"),
        (["--bbox", "-1,42,-2,43", *out], "--bbox -1,42,-2,43 is empty"),
        (["--bbox", "1,42,200,43", *out], "--bbox 1,42,200,43 is not on Earth"),
        (["--bbox", BBOX, "--no-osm", "--no-dem", *out], "--no-osm and --no-dem leave nothing to fetch"),
        (["--bbox", BBOX, "--overpass", "localhost", *out], "--overpass localhost is no address; give one that"),
        (["--bbox", BBOX, "--overpass", "file:///x", *out], "--overpass file:///x is no address"),
        (["--bbox", BBOX, "--extract", "ftp://x/y.pbf", *out], "--extract ftp://x/y.pbf is no address"),
        (["--bbox", BBOX, "--dem-model", "glo30", *out], "--dem-model glo30 is unknown; "),
        (["--bbox", BBOX, "--dem-url", "http://x/{z}.tif", *out], "--dem-url http://x/{z}.tif has {z}, which stands"),
        (["--bbox", BBOX, "--dem-url", "http://x/y.tif", *out], "--dem-url http://x/y.tif is the same for all files"),
    ]
    for arguments, message in cases:
        said = error_of(capsys, "fetch", *arguments, status=2)
        assert said.startswith(f"Error: {message}")
    assert list(tmp_path.iterdir()) == []


def test_files_are_not_replaced_unasked(
    server: WebServer, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "dem.tif").write_bytes(b"mine")
    said = error_of(capsys, *words(server, tmp_path))
    assert said.endswith("dem.tif exists; give another folder with -o, or --overwrite to replace it")
    assert server.requests == []
    assert (tmp_path / "out" / "dem.tif").read_bytes() == b"mine"


def test_nothing_to_drive_on(server: WebServer, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = words(server, tmp_path)
    command[command.index(BBOX)] = "1.9,42.1,1.91,42.11"
    said = error_of(capsys, *command)
    assert "has no way that cars can drive on in bbox 1.9,42.1,1.91,42.11; choose another area" in said
    assert list((tmp_path / "out").iterdir()) == []


def test_offline_it_says_so_in_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with web_server() as gone:
        command = words(gone, tmp_path)
    assert main(command) == 1
    (said,) = capsys.readouterr().err.splitlines()
    assert said.startswith(f"osm2xodr: error: {gone.url}/api/interpreter cannot be reached (connection refused)")
    assert "this machine may be offline; connect it, give another address with --overpass" in said
    # Several servers make no more of it.
    assert main([*command, "--overpass", f"{gone.url}/other"]) == 1
    (said,) = capsys.readouterr().err.splitlines()
    assert said.startswith("osm2xodr: error: none of the servers of the Overpass API can be reached (127.0.0.1:")


def test_encrypted_connections(
    tile: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    certificate = write_certificate(tmp_path / "certificate.pem")
    with web_server(certificate) as server:
        server.serve("/api/interpreter", Overpass())
        server.serve_file(tile_path(1, 42), tile)
        said = error_of(capsys, *words(server, tmp_path))
        assert f"{server.url}/api/interpreter does not prove that it is 127.0.0.1:" in said
        assert (
            "set SSL_CERT_FILE to the certificates of your network, or give another address with --overpass" in said
        )
        assert server.requests == []
        monkeypatch.setenv("SSL_CERT_FILE", str(certificate))
        assert main(words(server, tmp_path)) == 0


def test_a_disk_that_is_full(server: WebServer, tmp_path: Path) -> None:
    """The kernel lets no file grow beyond some size, in a process of its own; with more room it goes on."""
    script = (
        "import resource, sys\n"
        "from osm2xodr.cli import main\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]),) * 2)\n"
        "sys.exit(main(sys.argv[2:]))\n"
    )
    extract = ["--extract", str(SAMPLE / "area.osm")]
    for room, more in ((50_000, []), (170_000, []), (5_000, extract), (50_000, extract)):
        command = [sys.executable, "-c", script, str(room), *words(server, tmp_path), *more]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        assert (run.returncode, run.stderr.count("\n")) == (1, 1)
        assert "cannot be written" in run.stderr or "cannot write" in run.stderr
        assert list((tmp_path / "out").iterdir()) == []
    assert main(words(server, tmp_path)) == 0
    assert not [path for path in tmp_path.rglob("*") if path.name.startswith((".osm2xodr", "work-"))]


def test_two_at_once_wait_for_each_other(server: WebServer, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "osm2xodr", *words(server, tmp_path)]
    place = command.index(str(tmp_path / "out"))
    runs = []
    for name in ("a", "b", "c"):
        command[place] = str(tmp_path / name)
        runs.append(subprocess.Popen(command, stderr=subprocess.PIPE, text=True))
    said = [run.communicate(timeout=120)[1] for run in runs]
    assert [run.returncode for run in runs] == [0, 0, 0], said
    assert server.most_at_once == 1
    # The first one's answers serve all.
    assert len(server.asked("/api/interpreter")) == 2
    assert len({(tmp_path / name / "dem.tif").read_bytes() for name in "abc"}) == 1


def test_one_that_is_killed_leaves_nothing_that_looks_whole(server: WebServer, tmp_path: Path) -> None:
    server.serve("/api/interpreter", Overpass(), Reply(bytes(1000), step=1, pause=0.05))
    for number in (signal.SIGTERM, signal.SIGKILL):
        run = subprocess.Popen([sys.executable, "-m", "osm2xodr", *words(server, tmp_path)], stderr=subprocess.PIPE)
        until = time.monotonic() + 60.0
        before = len(server.requests)
        while len(server.requests) < before + (2 if number == signal.SIGTERM else 1) and time.monotonic() < until:
            time.sleep(0.01)
        time.sleep(0.2)
        run.send_signal(number)
        said = run.communicate(timeout=60)[1].decode()
        assert run.returncode == (143 if number == signal.SIGTERM else -9)
        assert ("ended by the system" in said) is (number == signal.SIGTERM)
        assert list((tmp_path / "out").iterdir()) == []
    server.serve("/api/interpreter", Overpass())
    assert main(words(server, tmp_path)) == 0


def test_a_time_limit_holds(server: WebServer, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    server.serve("/api/interpreter", Reply(PAGE, 429, {"Retry-After": "60"}))
    began = time.monotonic()
    said = error_of(capsys, *words(server, tmp_path, "--timeout", "1s"))
    assert "it takes longer than --timeout 1 s" in said
    assert time.monotonic() - began < 5.0


def test_the_models_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fetch", "--list-models"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split()[:3] == ["copernicus-glo30", "30", "m"]
    assert {line.split()[0] for line in lines} >= {"usgs-3dep-10m", "swissalti3d", "austria-als-dtm"}


def test_quiet_is_quiet(server: WebServer, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words(server, tmp_path, "-q")) == 0
    assert capsys.readouterr().err == ""
