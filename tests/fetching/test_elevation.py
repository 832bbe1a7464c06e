"""Windows of elevation models over the network."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from map_service import height, template, tile_of, tile_path
from rasterio import Affine
from web_server import PAGE, Reply, Request, WebServer, part_of, web_server, write_certificate

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import CoverageError, InputError, OutputError
from osm2xodr.fetching import ElevationModel, FetchOptions, Network, ServerError, read_models
from osm2xodr.fetching.connection import Connection
from osm2xodr.fetching.elevation import FetchedModel, fetch_models, with_margin
from osm2xodr.surface.grids import describe_dem

BOX = (1.55, 42.54, 1.60, 42.57)
TILE = tile_path(1, 42)


@pytest.fixture
def server() -> Iterator[WebServer]:
    with web_server() as made:
        yield made


@pytest.fixture(scope="module")
def tile() -> bytes:
    return tile_of(1, 42)


def model_on(server: WebServer, *urls: str, **more: Any) -> ElevationModel:
    """Return the default model as if it were on a server."""
    how = {"urls": urls or (template(server),), **more}
    return replace(read_models(())["copernicus-glo30"], **how)


class Fetch:
    """Fetches into a folder."""

    def __init__(self, folder: Path, server: WebServer) -> None:
        self.folder, self.server = folder, server
        self.said: list[str] = []
        self.waited: list[float] = []

    def __call__(
        self, *models: ElevationModel, box: tuple[float, float, float, float] = BOX, age: float = 1.0, **more: Any
    ) -> list[FetchedModel]:
        network = Network(**{"retries": 2, "note": self.said.append, "sleep": self.waited.append, **more})
        options = FetchOptions(self.folder, self.folder / "cache", age=age, network=network)
        return fetch_models(Connection(network), box, models or [model_on(self.server)], options, self.folder)

    def files(self) -> list[str]:
        return sorted(path.name for path in self.folder.iterdir() if path.suffix == ".tif")


@pytest.fixture
def fetch(tmp_path: Path, server: WebServer) -> Fetch:
    return Fetch(tmp_path, server)


def check_heights(path: Path, box: tuple[float, float, float, float] = BOX) -> Any:
    """Check that a file has the terrain in a box, and return its cells without a height."""
    with rasterio.open(path) as dem:
        cells = dem.read(1)
        rows, cols = np.indices(dem.shape)
        lon = dem.transform.c + dem.transform.a * (cols + 0.5)
        lat = dem.transform.f + dem.transform.e * (rows + 0.5)
        bounds, void = dem.bounds, cells == dem.nodata
    np.testing.assert_array_equal(cells[~void], height(lon, lat)[~void])
    assert bounds.left <= box[0]
    assert bounds.bottom <= box[1]
    assert bounds.right >= box[2]
    assert bounds.top >= box[3]
    return void


def packed(cells: Any, transform: Affine, crs: str | None = "EPSG:4326", **more: Any) -> bytes:
    """Return a GeoTIFF."""
    scales, units = more.pop("scales", None), more.pop("units", None)
    with rasterio.MemoryFile() as memory:
        with memory.open(
            driver="GTiff", width=cells.shape[1], height=cells.shape[0], count=1, dtype=cells.dtype.name, crs=crs,
            transform=transform, **more,
        ) as dataset:  # fmt: skip
            dataset.write(cells, 1)
            if scales is not None:
                dataset.scales = scales
            if units is not None:
                dataset.units = units
        return bytes(memory.getbuffer())


def test_only_the_part_that_is_needed_is_read(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    server.serve_file(TILE, tile)
    (made,) = fetch()
    assert not check_heights(made.paths[0]).any()
    assert (made.urls, made.absent, made.voids) == ((server.url + TILE,), 0, 0.0)
    with rasterio.open(made.paths[0]) as dem:
        # Cells of 3 arc seconds: 60 by 36 of the area, and 38 on each side.
        assert dem.shape == (36 + 77, 60 + 77)
        assert dem.dtypes == ("float32",)
    sent = [part_of(tile, item) for item in server.requests if item.method == "GET"]
    assert sum(len(reply.body) for reply in sent) < len(tile) / 2
    assert server.most_at_once == 1
    assert all(item.headers["User-Agent"].startswith("osm2xodr/") for item in server.requests)


def test_what_is_written_is_known_as_a_surface_model_with_its_datum(
    server: WebServer, fetch: Fetch, tile: bytes
) -> None:
    server.serve_file(TILE, tile)
    found = describe_dem(fetch()[0].paths[0], Diagnostics())
    assert found.covered is True
    assert found.datum is not None
    assert found.datum.name == "EGM2008 height"
    assert found.crs.to_epsg() == 4326
    path = fetch(model_on(server, covered=False, datum=""), age=0.0)[0].paths[0]
    ground = describe_dem(path, Diagnostics())
    assert ground.datum is None


def test_tiles_are_put_together_without_a_seam(server: WebServer, fetch: Fetch) -> None:
    for west in (1, 2):
        for south in (42, 43):
            server.serve_file(tile_path(west, south), tile_of(west, south, 240))
    box = (1.9, 42.9, 2.1, 43.1)
    (made,) = fetch(box=box)
    assert not check_heights(made.paths[0], box).any()
    assert len(made.urls) == 4
    assert fetch.files() == ["dem.tif"]


def test_a_tile_that_is_not_there_is_sea(server: WebServer, fetch: Fetch) -> None:
    for west, south in ((1, 42), (2, 43)):
        server.serve_file(tile_path(west, south), tile_of(west, south, 240))
    box = (1.9, 42.9, 2.1, 43.1)
    (made,) = fetch(box=box)
    void = check_heights(made.paths[0], box)
    assert made.absent == 2
    assert made.voids == pytest.approx(void.mean())
    assert 0.4 < void.mean() < 0.6


def test_cells_of_another_width_get_a_file_of_their_own(server: WebServer, fetch: Fetch) -> None:
    """Copernicus' cells are wider from latitude 50 on."""
    server.serve_file(tile_path(1, 49), tile_of(1, 49, 240))
    server.serve_file(tile_path(1, 50), tile_of(1, 50, 240, 160))
    (made,) = fetch(box=(1.4, 49.95, 1.6, 50.05))
    assert fetch.files() == ["dem.tif", "dem_2.tif"]
    assert [path.name for path in made.paths] == fetch.files()
    check_heights(made.paths[0], (1.4, 49.95, 1.6, 49.99))
    check_heights(made.paths[1], (1.4, 50.01, 1.6, 50.05))


def test_several_models_in_their_order(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    server.serve_file(TILE, tile)
    server.serve_file("/fine/42_1.tif", tile_of(1, 42, 2400))
    fine = model_on(server, f"{server.url}/fine/{{lat}}_{{lon}}.tif", title="Fine")
    none = model_on(server, f"{server.url}/none/{{lat}}_{{lon}}.tif", title="None")
    made = fetch(none, fine, model_on(server))
    assert [item.model.title for item in made] == ["Fine", "Copernicus GLO-30"]
    assert fetch.said == ["None has no heights in the area"]
    sizes = []
    for name in ("dem.tif", "dem_2.tif"):
        check_heights(fetch.folder / name)
        with rasterio.open(fetch.folder / name) as dem:
            sizes.append(dem.width)
    assert sizes == [120 + 77, 60 + 77]


def test_nothing_is_there(server: WebServer, fetch: Fetch) -> None:
    with pytest.raises(CoverageError, match="Copernicus GLO-30: there are no heights in the area; choose"):
        fetch()
    assert fetch.files() == []


def test_the_next_address_is_tried_where_a_file_is_not_there(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    server.serve_file("/2019/42_1.tif", tile)
    years = [f"{server.url}/{year}/{{lat}}_{{lon}}.tif" for year in (2025, 2022, 2019, 2016)]
    (made,) = fetch(model_on(server, *years))
    assert made.urls == (f"{server.url}/2019/42_1.tif",)
    assert {item.path for item in server.requests} == {f"/{year}/42_1.tif" for year in (2025, 2022, 2019)}


def test_the_next_address_is_tried_where_one_fails(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    addresses = [f"{server.url}/{name}/{{lat}}_{{lon}}.tif" for name in ("a", "b", "c")]
    server.serve("/a/42_1.tif", Reply(PAGE, 403))
    server.serve_file("/c/42_1.tif", tile)
    (made,) = fetch(model_on(server, *addresses))
    assert made.urls == (f"{server.url}/c/42_1.tif",)
    assert "answers with status 403" in fetch.said[0]
    assert fetch.said[0].endswith(f"{server.url}/c/42_1.tif was taken instead")
    # Where none has it, it may be there all the same.
    with pytest.raises(ServerError, match="answers with status 403"):
        fetch(model_on(server, *addresses[:2]))


def test_areas_beyond_a_model_or_too_large_for_it(server: WebServer, fetch: Fetch) -> None:
    with pytest.raises(CoverageError, match="has heights from 8 to 14 E and 47 to 51 N, and the area lies elsewhere"):
        fetch(model_on(server, extent=(8.0, 47.0, 14.0, 51.0)))
    with pytest.raises(InputError, match="the area has 1,233 million cells of Copernicus GLO-30, more than"):
        fetch(box=(0.0, 0.0, 10.0, 9.0))
    assert server.requests == []


def test_what_was_read_is_kept(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    server.serve_file(TILE, tile)
    first = fetch()[0].paths[0].read_bytes()
    server.requests.clear()
    assert fetch()[0].paths[0].read_bytes() == first
    assert server.requests == []
    # What is damaged is read anew.
    (kept,) = (fetch.folder / "cache" / "elevation").iterdir()
    kept.write_bytes(kept.read_bytes()[: kept.stat().st_size // 2])
    assert fetch()[0].paths[0].read_bytes() == first
    assert len(server.requests) > 1
    server.requests.clear()
    fetch(age=0.0)
    assert len(server.requests) > 1


def test_it_goes_on_with_the_file_that_is_missing(server: WebServer, fetch: Fetch) -> None:
    server.serve_file(tile_path(1, 42), tile_of(1, 42, 240))
    server.serve(tile_path(2, 42), Reply(PAGE, 503))
    box = (1.9, 42.5, 2.1, 42.6)
    with pytest.raises(ServerError, match=r"has an error \(status 503\), also after 2 .* with --dem-url"):
        fetch(box=box)
    assert fetch.files() == []
    before = len(server.asked(tile_path(1, 42)))
    server.serve_file(tile_path(2, 42), tile_of(2, 42, 240))
    (made,) = fetch(box=box)
    check_heights(made.paths[0], box)
    assert len(server.asked(tile_path(1, 42))) == before


def test_a_busy_server_is_asked_again(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    server.serve_file(TILE, tile, Reply(PAGE, 429, {"Retry-After": "9"}))
    check_heights(fetch()[0].paths[0])
    assert fetch.waited == [9.0]


PROBE = "bytes=0-16383"


def faulty(tile: bytes, number: int, reply: Callable[[Request], Reply]) -> Callable[[Request], Reply]:
    """Answer one request for a part with something else."""
    seen: list[Request] = []

    def answer(request: Request) -> Reply:
        seen.append(request)
        return reply(request) if len(seen) == number + 1 else part_of(tile, request)

    return answer


@pytest.mark.parametrize("number", [1, 2])
@pytest.mark.parametrize(
    "fault",
    [
        lambda request: Reply(cut=0),
        lambda request: part_of(tile_of(1, 42), request, cut=100),
        lambda request: Reply(PAGE, 503),
        lambda request: Reply(PAGE, 429, {"Retry-After": "3"}),
        lambda request: Reply(PAGE, 504),
    ],
)
def test_faults_between_the_cells(
    server: WebServer, fetch: Fetch, tile: bytes, number: int, fault: Callable[[Request], Reply]
) -> None:
    """After the file was seen to be there: while GDAL reads its structure, or its cells."""
    server.serve(TILE, faulty(tile, number, fault))
    check_heights(fetch()[0].paths[0])
    assert "it is asked again in" in fetch.said[0]
    assert fetch.waited in ([5.0], [3.0])


def test_a_server_that_always_cuts(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    def cuts(request: Request) -> Reply:
        return part_of(tile, request) if request.headers.get("Range") == PROBE else Reply(cut=0)

    server.serve(TILE, cuts)
    with pytest.raises(ServerError, match=r"cut the connection, also after 2 further tries; try again"):
        fetch()
    assert fetch.waited == [5.0, 10.0]
    assert fetch.files() == []


def test_a_file_that_changes_while_it_is_read(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    server.serve(TILE, faulty(tile, 1, lambda request: part_of(tile_of(1, 42, 1000), request)))
    with pytest.raises(ServerError, match="has changed while it was read; start the same command again"):
        fetch()


def test_what_is_read_in_parts_is_bounded(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    server.serve_file(TILE, tile)
    with pytest.raises(ServerError, match="to be read, but --max-download allows no more"):
        fetch(download_max=10_000)


def test_no_part_is_read_over_an_open_connection(
    server: WebServer, fetch: Fetch, tile: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A server of the secure kind leads to the open one when its file is read."""
    certificate = write_certificate(tmp_path / "certificate.pem")
    monkeypatch.setenv("SSL_CERT_FILE", str(certificate))
    server.serve_file("/private.tif", tile)
    with web_server(certificate) as secure:
        secure.serve_file("/42_1.tif", tile)
        check_heights(fetch(model_on(secure, f"{secure.url}/{{lat}}_{{lon}}.tif"))[0].paths[0])
        away = Reply(status=302, headers={"Location": f"{server.url}/private.tif"})
        secure.serve("/42_1.tif", lambda request: part_of(tile, request), away)
        with pytest.raises(ServerError, match="which is not followed"):
            fetch(model_on(secure, f"{secure.url}/{{lat}}_{{lon}}.tif"), age=0.0)
    assert server.requests == []


def test_a_slow_trickle_of_cells_ends(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    def slow(request: Request) -> Reply:
        return part_of(tile, request, step=10, pause=0.1)

    server.serve(TILE, faulty(tile, 2, slow))
    check_heights(fetch(patience=1.0)[0].paths[0])
    assert "sends less than 1 kB/s; it is asked again" in fetch.said[0]


@pytest.mark.parametrize(
    ("reply", "message"),
    [
        (Reply(PAGE), r"gives a web page \(Please log in to this network.\) instead of a GeoTIFF; check the address"),
        (Reply(PAGE, headers={"Content-Type": "image/tiff"}), r"gives a web page \(.*\) instead of a GeoTIFF"),
        (
            Reply(b"{}", headers={"Content-Type": "application/json"}),
            r"something else \(application/json\) ",
        ),
        (Reply(PAGE, 403), "answers with status 403: Please log in to this network"),
        (Reply(status=302, headers={"Location": "file:///etc/passwd"}), "which is not followed"),
    ],
)
def test_files_that_are_none(server: WebServer, fetch: Fetch, reply: Reply, message: str) -> None:
    server.serve(TILE, reply)
    with pytest.raises(ServerError, match=message):
        fetch()
    assert fetch.files() == []


def test_a_file_that_begins_like_a_raster(server: WebServer, fetch: Fetch) -> None:
    server.serve_file(TILE, b"II*\0" + bytes(100_000))
    with pytest.raises(ServerError, match="cannot be read to its end"):
        fetch()


def test_redirects_are_followed(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    server.serve(TILE, Reply(status=302, headers={"Location": "/elsewhere.tif"}))
    server.serve_file("/elsewhere.tif", tile)
    check_heights(fetch()[0].paths[0])


def test_a_server_without_parts_is_read_whole_once(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    server.serve_file(TILE, tile, ranges=False)
    check_heights(fetch()[0].paths[0])
    assert fetch.said == [
        f"{server.url.partition('//')[2]} does not send parts of files; {server.url}{TILE} is downloaded whole"
    ]
    whole = len(server.asked(TILE))
    box = (1.2, 42.2, 1.3, 42.3)
    check_heights(fetch(box=box)[0].paths[0], box)
    # It is only seen to be there.
    assert len(server.asked(TILE)) == whole + 1


def test_files_say_whom_they_are_owed(server: WebServer, fetch: Fetch, tile: bytes) -> None:
    """Fetched, and out of what is kept of before."""
    server.serve_file(TILE, tile)
    for _ in range(2):
        (made,) = fetch(replace(model_on(server), attribution="© Me & you"))
        with rasterio.open(made.paths[0]) as dem:
            assert dem.tags()["TIFFTAG_COPYRIGHT"] == "© Me & you"


def test_whole_numbers_stay_what_they_are(server: WebServer, fetch: Fetch) -> None:
    cells = np.arange(1.0, 10_001.0).reshape(100, 100).astype(np.uint16)
    place = Affine(0.001, 0, 1.5, 0, -0.001, 42.6)
    server.serve_file("/a.tif", packed(cells, place, scales=(0.1,), units=("ft",)))
    (made,) = fetch(model_on(server, f"{server.url}/a.tif", tile=0.0, datum=""))
    with rasterio.open(made.paths[0]) as dem:
        # Without a value for none they have to be given room for it.
        assert (dem.dtypes, dem.nodata, dem.scales, dem.units) == (("float32",), -32768.0, (0.1,), ("ft",))
        col, row = round((dem.transform.c - 1.5) / 0.001), round((42.6 - dem.transform.f) / 0.001)
        np.testing.assert_array_equal(dem.read(1), cells[row : row + dem.height, col : col + dem.width])
        assert made.voids == 0.0
    server.serve_file("/a.tif", packed(cells.astype(np.int16), place, nodata=7))
    (made,) = fetch(model_on(server, f"{server.url}/a.tif", tile=0.0, datum=""), age=0.0)
    with rasterio.open(made.paths[0]) as dem:
        assert (dem.dtypes, dem.nodata) == (("int16",), 7.0)


def test_models_in_metres(server: WebServer, fetch: Fetch) -> None:
    """Tiles of 10 km in a projection: those that the area needs, and no others."""
    cells = np.full((100, 100), 5.0, np.float32)
    box = with_margin((1.56, 42.55, 1.59, 42.565))
    corners = {(380, 4710), (380, 4700)}
    for x, y in corners:
        place = Affine(100, 0, 1000.0 * x, 0, -100, 1000.0 * y + 10_000)
        server.serve_file(f"/{x}_{y}.tif", packed(cells, place, "EPSG:25831"))
    url = f"{server.url}/{{x_km}}_{{y_km}}.tif"
    (made,) = fetch(model_on(server, url, crs="EPSG:25831", tile=10_000.0, datum="EPSG:5782"), box=box)
    assert made.urls == (f"{server.url}/380_4710.tif",)
    with rasterio.open(made.paths[0]) as dem:
        assert "Alicante height" in dem.crs.to_wkt()
        assert (dem.read(1) == 5.0).all()


def test_a_service_is_asked_once_for_each_cut_out(server: WebServer, fetch: Fetch) -> None:
    """It makes cut-outs anew for each request, and may leave out where they lie: that was asked for."""
    made: list[str] = []

    def cut_out(request: Request) -> Reply:
        assert (request.query["REQUEST"], request.headers.get("Range")) == ("GetCoverage", None)
        made.append(request.query["BBOX"])
        west, south, east, north = map(int, made[-1].split(","))
        assert (east - west, north - south) == (1000, 1000)
        x = west + np.arange(100) * 10.0
        cells = np.tile(x.astype(np.float32), (100, 1))
        return Reply(packed(cells, Affine(10, 0, west, 0, -10, north), None))

    url = server.serve("/wcs", cut_out)
    url += "?SERVICE=WCS&REQUEST=GetCoverage&BBOX={x},{y},{x+1000},{y+1000}"
    box = with_margin((1.56, 42.55, 1.575, 42.555))
    (found,) = fetch(model_on(server, url, crs="EPSG:25831", tile=1000.0, datum="EPSG:5782", cell=10.0), box=box)
    assert len(made) == len(set(made)) == len(found.urls) > 3
    assert found.urls[0] == f"{url.partition('?')[0]}?SERVICE=WCS&REQUEST=GetCoverage&BBOX={made[0]}"
    with rasterio.open(found.paths[0]) as dem:
        assert "UTM zone 31N" in dem.crs.to_wkt()
        assert "Alicante height" in dem.crs.to_wkt()
        columns = dem.transform.c + 10.0 * np.arange(dem.width)
        assert (dem.read(1) == columns.astype(np.float32)).all()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (packed(np.zeros((9, 9), np.float32), Affine(1, 0, 0, 0, 1, 40)), "is not laid out from north to south"),
        (packed(np.zeros((9, 9), np.float32), Affine(1, 0.1, 0, 0, -1, 45)), "is not laid out from north to south"),
    ],
)
def test_rasters_of_no_use(server: WebServer, fetch: Fetch, content: bytes, message: str) -> None:
    server.serve_file("/a.tif", content)
    with pytest.raises(InputError, match=f"the file of Copernicus GLO-30 {message}; choose another model"):
        fetch(model_on(server, f"{server.url}/a.tif", tile=0.0))


def test_a_crs_that_is_none(server: WebServer, fetch: Fetch) -> None:
    with pytest.raises(InputError, match=r"crs 'EPSG:0' of an elevation model is none \(.*\); see docs/fetch.md"):
        fetch(model_on(server, crs="EPSG:0"))


def test_a_folder_that_cannot_be_written(server: WebServer, fetch: Fetch, tile: bytes, tmp_path: Path) -> None:
    server.serve_file(TILE, tile)
    (tmp_path / "dem.tif").mkdir()
    with pytest.raises(OutputError, match=r"cannot write .*dem.tif: is a directory"):
        fetch()
