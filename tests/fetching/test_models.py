"""The table of elevation models."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import rasterio.crs

from osm2xodr.errors import InputError, OptionError
from osm2xodr.fetching import ELEVATION_MODEL, ElevationModel, read_models
from osm2xodr.fetching.models import choose_models
from osm2xodr.fetching.rasters import bounds_in

DOCS = Path(__file__).parents[2] / "docs" / "fetch.md"
MINE = """
[mine]
title = My model
kind = dtm
cell = 1
crs = EPSG:25832
tile = 1000
url = http://localhost/{x_km}_{y_km}.tif
licence = CC BY 4.0
attribution = Me
"""


def files_at(model: ElevationModel, lon: float, lat: float) -> list[str]:
    """Return the first address of the files that hold a place."""
    box = bounds_in(model.crs, (lon, lat, lon + 1e-6, lat + 1e-6))
    return [addresses[0].rpartition("/")[2] for addresses in model.files(box)]


@pytest.mark.parametrize(
    ("name", "lon", "lat", "file"),
    [
        ("copernicus-glo30", 1.5, 42.5, "Copernicus_DSM_COG_10_N42_00_E001_00_DEM.tif"),
        ("copernicus-glo30", -0.5, -0.5, "Copernicus_DSM_COG_10_S01_00_W001_00_DEM.tif"),
        ("copernicus-glo30", 0.5, 0.5, "Copernicus_DSM_COG_10_N00_00_E000_00_DEM.tif"),
        ("copernicus-glo30", -171.5, -13.5, "Copernicus_DSM_COG_10_S14_00_W172_00_DEM.tif"),
        ("copernicus-glo90", 120.5, 60.5, "Copernicus_DSM_COG_30_N60_00_E120_00_DEM.tif"),
        # Named after their north-west corners.
        ("usgs-3dep-10m", -119.5, 38.5, "USGS_13_n39w120.tif"),
        ("usgs-3dep-30m", -149.5, 68.5, "USGS_1_n69w150.tif"),
        ("swissalti3d", 7.2325, 46.3225, "swissalti3d_2025_2584-1130_2_2056_5728.tif"),
        ("austria-als-dtm", 11.39, 47.26, "ALS_DTM_CRS3035RES50000mN2650000E4400000.tif"),
        ("bavaria-dgm1", 11.576, 48.137, "691_5334.tif"),
        ("nrw-dgm1", 6.96, 50.94, "dgm1_32_356_5645_1_nw_2025.tif"),
        ("rhineland-palatinate-dgm1", 7.9, 49.55, "dgm1_32_420_5489_1_rp_2025.tif"),
    ],
)
def test_files_are_named_as_their_publishers_do(name: str, lon: float, lat: float, file: str) -> None:
    assert files_at(read_models(())[name], lon, lat) == [file]


def test_cut_outs_are_asked_for_by_their_corners() -> None:
    models = read_models(())
    (norway,) = models["norway-dtm1"].files((130_100.0, 6_840_100.0, 130_200.0, 6_840_200.0))
    assert "&BBOX=130000,6840000,131000,6841000&WIDTH=1000&HEIGHT=1000&" in norway[0]
    (france,) = models["france-lidar-hd"].files((957_100.0, 6_217_100.0, 957_200.0, 6_217_200.0))
    assert "&BBOX=956999.75,6217000.25,957999.75,6218000.25&WIDTH=2000&HEIGHT=2000" in france[0]
    (hesse,) = models["hesse-dgm1"].files((475_100.0, 5_550_100.0, 475_200.0, 5_550_200.0))
    assert hesse[0].endswith("&SUBSET=E(475000,476000)&SUBSET=N(5550000,5551000)")
    (mecklenburg,) = models["mecklenburg-dgm1"].files((413_300.0, 6_047_000.0, 413_400.0, 6_047_100.0))
    assert mecklenburg[0].endswith("&file=dgm1_33_412_6046_2_gtiff.tif")


def test_models_without_addresses_say_how_to_get_them() -> None:
    models = read_models(())
    text = (
        r"^dem_model fabdem has to be got by hand: download from its page the archive .* \(https://data.bris.ac.uk/"
    )
    with pytest.raises(OptionError, match=text):
        choose_models(["copernicus-glo30", "fabdem"], models, None)
    (model,) = choose_models(["fabdem"], models, "http://localhost/{NS}{lat:02}{EW}{lon:03}_FABDEM_V1-2.tif")
    assert files_at(model, 1.5, 42.5) == ["N42E001_FABDEM_V1-2.tif"]


def test_all_files_of_an_area_are_asked_for() -> None:
    model = read_models(())["copernicus-glo30"]
    names = [re.findall(r"[NS]\d\d_00_[EW]\d{3}", urls[0])[0] for urls in model.files((-1.2, -0.3, 0.4, 0.2))]
    assert names == ["S01_00_W002", "S01_00_W001", "S01_00_E000", "N00_00_W002", "N00_00_W001", "N00_00_E000"]
    # A border belongs to one side.
    assert len(model.files((1.0, 42.0, 2.0, 43.0))) == 1


def test_the_table_is_sound() -> None:
    models = read_models(())
    assert next(iter(models)) == ELEVATION_MODEL
    for name, model in models.items():
        assert re.fullmatch(r"[a-z0-9-]+", name)
        assert all(url.startswith("https://") for url in model.urls)
        assert model.page.startswith("https://")
        code = f"{model.crs}+{model.datum.removeprefix('EPSG:')}" if model.datum else model.crs
        assert ("VERT" in rasterio.crs.CRS.from_user_input(code).to_wkt()) is bool(model.datum)
        west, south, east, north = model.extent
        assert west < east
        assert south < north


def test_the_document_lists_the_table() -> None:
    text = DOCS.read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([a-z0-9-]+)`([^|]*) \| ([\d.]+) m \| ([^|]+) \|", text, re.MULTILINE)
    notes = {ELEVATION_MODEL: " (default)"}
    models = read_models(())
    shows = {True: "canopy and roofs", False: "ground"}
    assert rows == [
        (name, " (by hand)" if model.by_hand else notes.get(name, ""), f"{model.cell:g}", shows[model.covered])
        for name, model in models.items()
    ]
    example = re.search(r"```ini\n(.*?)```", text, re.DOTALL)
    assert example is not None


def test_the_example_of_the_document_works(tmp_path: Path) -> None:
    example = re.search(r"```ini\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    assert example is not None
    (tmp_path / "my.ini").write_text(example[1], encoding="utf-8")
    model = read_models([tmp_path / "my.ini"])["my-county"]
    assert [url.rpartition("/")[2] for url in model.files((690_100.0, 5_334_100.0, 690_200.0, 5_334_200.0))[0]] == [
        "dgm1_690_5334.tif",
        "dgm1_690_5334.tif",
    ]
    assert (model.covered, model.cell, model.datum) == (False, 1.0, "EPSG:7837")


def test_a_file_of_the_user_adds_and_replaces(tmp_path: Path) -> None:
    path = tmp_path / "mine.ini"
    path.write_text(MINE + MINE.replace("[mine]", "[copernicus-glo90]").replace("{y_km}", "{y_km}%20x"))
    models = read_models([path])
    assert models["mine"].title == models["copernicus-glo90"].title == "My model"
    assert models["mine"].extent == (-180.0, -90.0, 180.0, 90.0)
    assert models["copernicus-glo90"].files((100.0, 100.0, 200.0, 200.0)) == [("http://localhost/0_0%20x.tif",)]
    assert models["copernicus-glo30"].title == "Copernicus GLO-30"


def test_one_file_for_everything(tmp_path: Path) -> None:
    path = tmp_path / "mine.ini"
    path.write_text(MINE.replace("tile = 1000", "").replace("{x_km}_{y_km}", "all"))
    assert read_models([path])["mine"].files((0.0, 0.0, 1e6, 1e6)) == [("http://localhost/all.tif",)]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("kind = dtm", "kind = dem", r"\[mine\]: kind is 'dem'; write dtm or dsm"),
        ("cell = 1", "cell = one", r"\[mine\]: cell is 'one'; write a number"),
        ("cell = 1", "cell = 0", r"\[mine\]: cell and tile are lengths; write numbers above 0"),
        ("title = My model", "", r"\[mine\]: title is missing"),
        ("licence", "license", r"\[mine\]: 'license' is no key of an elevation model; the keys are title, "),
        ("tile = 1000", "corner = middle", r"\[mine\]: corner is 'middle'; write south-west or north-west"),
        ("tile = 1000", "extent = 1, 2, 3", r"\[mine\]: extent is '1, 2, 3'; write 4 numbers with commas"),
        ("{y_km}", "{year}", r"\[mine\]: url .* has \{year\}, which stands for nothing"),
        ("{y_km}", "{x.__class__}", r"has \{x.__class__\}, which stands for nothing"),
        ("{x_km}_{y_km}", "all", r"\[mine\]: url .* is the same for all files of the model"),
        ("http://", "file://", r"\[mine\]: url file://localhost/0_0.tif is no address"),
        ("[mine]", "", "is no table of elevation models"),
        ("[mine]", "[mine]\n[mine]", "is no table of elevation models"),
    ],
)
def test_what_is_wrong_with_a_file_of_the_user(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "mine.ini"
    path.write_text(MINE.replace(old, new))
    with pytest.raises(InputError, match=message) as caught:
        read_models([path])
    assert str(path) in str(caught.value)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none.ini cannot be read: no such file or directory; check the path given"):
        read_models([tmp_path / "none.ini"])
    (tmp_path / "a.ini").write_bytes(b"[a]\ntitle = \xff\xff")
    with pytest.raises(InputError, match="is no table of elevation models"):
        read_models([tmp_path / "a.ini"])


def test_models_are_chosen_by_name() -> None:
    models = read_models(())
    assert [model.name for model in choose_models(["swissalti3d", "copernicus-glo30"] * 2, models, None)] == [
        "swissalti3d",
        "copernicus-glo30",
    ]
    with pytest.raises(OptionError, match="dem_model copernicus-glo-30 is unknown; do you mean copernicus-glo30"):
        choose_models(["copernicus-glo-30"], models, None)
    (model,) = choose_models(["swissalti3d"], models, "http://localhost/{x_km}.tif")
    assert model.urls == ("http://localhost/{x_km}.tif",)
    assert model.attribution == "© swisstopo"
