"""Fuzzers: each makes a hostile input from a seed and hands it to a part of the program.

What may happen is a result or an `Osm2xodrError`. Everything else is a finding: another exception, a crash of the
process, or more than a minute of work.
"""

from __future__ import annotations

import contextlib
import gzip
import io
import math
import os
import random
import re
import signal
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from hostile_maps import odd_network, random_map

from osm2xodr.checking import CheckOptions, Severity, check_file
from osm2xodr.conventions.targets import SUPERELEVATION, TARGETS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import Osm2xodrError
from osm2xodr.exporting import write_geojson
from osm2xodr.furniture import EXTRA_OBJECTS, FurnitureOptions
from osm2xodr.geometry import ElevationOptions, RoadOptions
from osm2xodr.model import Rule
from osm2xodr.opendrive.reader import read_xodr
from osm2xodr.osmParsing import ParseOptions, parse_osm
from osm2xodr.osmParsing.options import PRESETS
from osm2xodr.pipeline import PipelineOptions, convert
from osm2xodr.projection import make_frame
from osm2xodr.surface import SurfaceOptions, read_surface
from osm2xodr.viewing import write_picture
from osm2xodr.viewing.options import PictureOptions
from osm2xodr.xodrWriter import WriteOptions, write_xodr

# A case that takes longer hangs, s.
HANG: Final = 60
_VERSIONS: Final = ("1.4", "1.6", "1.7", "1.8")


@dataclass(frozen=True)
class Finding:
    """What went wrong with a seed."""

    fuzzer: str
    seed: int
    what: str


def fuzz_map(dice: random.Random, folder: Path) -> None:
    """Convert a random map, write it, and check what was written."""
    area = folder / "area.osm"
    longest = 10_000 if dice.random() < 0.01 else 1000
    area.write_text((odd_network if dice.random() < 0.2 else random_map)(dice, longest), encoding="utf-8")
    reader = TARGETS[dice.choice(sorted(TARGETS))]
    extra = frozenset(EXTRA_OBJECTS if dice.random() < 0.7 else ())
    bumpy, wild = _bumpy_dem(area, folder, dice) if dice.random() < 0.15 else (None, False)
    options = PipelineOptions(
        area,
        dems=(bumpy,) if bumpy else (),
        parse=_parse_options(dice, extra),
        elevation=ElevationOptions(superelevation=dice.choice(SUPERELEVATION), structures=dice.random() < 0.8),
        surface=SurfaceOptions(allow_partial=dice.random() < 0.8),
        roads=RoadOptions(turnarounds=dice.random() < 0.3),
        furniture=FurnitureOptions(target=reader, extra_objects=extra, enabled=dice.random() < 0.9),
    )
    found = Diagnostics()
    road_map = convert(options, found).road_map
    target = folder / "out.xodr"
    with target.open("wb") as stream:
        write_xodr(road_map, stream, WriteOptions(version=dice.choice(_VERSIONS), target=reader), found)
    result = check_file(target, CheckOptions(ignore=("schema",)))
    # No junction can have one surface on ground that leaps by kilometres, or where level roads pass over each other
    # within metres of it, and random ways lie over each other without a common node; that this is told is all that is
    # asked.
    leaps = wild or (bumpy is None and road_map.statistics.get("layer_crossings", 0.0) > 0.0)
    allowed = {"clearance", "junction-surface"} if leaps else {"clearance"}
    worst = [str(item) for item in result.findings if item.severity is Severity.ERROR and item.rule not in allowed]
    assert not worst, worst[:3]


def _parse_options(dice: random.Random, extra: frozenset[str]) -> ParseOptions:
    return ParseOptions(
        ways=PRESETS[dice.choice(("drivable", "drivable", "all", "major"))],
        include_private=dice.random() < 0.3,
        rule=dice.choice((None, None, *Rule)),
        default_lane_width=dice.choice((None, None, 2.0, 3.3)),
        furniture=dice.random() < 0.9,
        extra_objects=extra,
    )


# Ground steeper than this between neighbouring cells of an elevation model is no ground that streets are built on.
_STEEP: Final = 0.3
_METRES_PER_DEGREE: Final = 111_195.0


def _bumpy_dem(area: Path, folder: Path, dice: random.Random) -> tuple[Path, bool]:
    """Write an elevation model around the first node of an area; say if it is wild.

    It is small noise, cliffs and voids, or hills under all nodes.
    """
    found = re.findall(r'lat="([-\d.]+)" lon="([-\d.]+)"', area.read_text(encoding="utf-8"))
    places = np.array(found, np.float64)
    lat, lon = places[0].tolist()
    noise = np.random.default_rng(dice.getrandbits(32))
    size = dice.choice((2, 5, 30))
    base, rough = dice.choice((0.0, 4000.0, -400.0)), dice.choice((0.0, 1.0, 30.0, 1e4))
    hilly = noise.random() < 0.5
    size = 30 if hilly else size
    heights = noise.normal(base, rough, (size, size))
    void, value = noise.random((size, size)) < dice.choice((0.0, 0.1, 0.9)), dice.choice((-32768.0, np.nan, 1e30))
    cell = dice.choice((1e-5, 3e-4, 3e-3))
    if hilly:
        far = np.abs((places - places[0] + 180.0) % 360.0 - 180.0).max()
        cell = max(cell, 2.2 * far / size)
    metres = cell * _METRES_PER_DEGREE * math.cos(math.radians(lat))
    if hilly:
        heights = base + _hills(size, metres, noise)
    steps = [np.abs(np.diff(heights, axis=axis)).max() for axis in (0, 1)]
    heights[void] = value
    path = folder / "under.tif"
    path.write_bytes(_as_tiff(heights.astype(np.float32), lon, lat, cell))
    return path, max(steps) > _STEEP * metres


def _hills(size: int, cell: float, noise: np.random.Generator) -> npt.NDArray[np.float64]:
    """Return hills of about a hundred metres and more, none of them steep, for cells of a size in metres."""
    at = cell * np.arange(size)
    out = np.zeros((size, size))
    for _ in range(4):
        number, direction, phase = 2 * np.pi / noise.uniform(100.0, 2000.0), *noise.uniform(0.0, 2 * np.pi, 2)
        along = np.add.outer(np.sin(direction) * at, np.cos(direction) * at)
        out += noise.uniform(0.0, 0.06) / number * np.sin(number * along + phase)
    return out


def fuzz_osm(dice: random.Random, folder: Path) -> None:
    """Read OSM files whose bytes are damaged."""
    text = (odd_network if dice.random() < 0.2 else random_map)(dice, 1000).encode()
    kind = dice.choice(("osm", "osm.gz", "osm.pbf"))
    if kind == "osm.pbf":
        text = _as_pbf(text, folder)
    if kind != "osm.pbf" and dice.random() < 0.3:
        text = _rearranged(text, dice)
    data = _damaged(gzip.compress(text, mtime=0) if kind == "osm.gz" else text, dice)
    path = folder / f"area.{kind}"
    path.write_bytes(data)
    parse_osm(path, _parse_options(dice, frozenset(EXTRA_OBJECTS)), Diagnostics())


def fuzz_dem(dice: random.Random, folder: Path) -> None:
    """Read elevation models whose bytes are damaged."""
    path = folder / "dem.tif"
    path.write_bytes(_damaged(_small_dem(), dice))
    x = np.linspace(-200.0, 200.0, 40)
    read_surface((path,), make_frame(42.56, 1.53), x, x, SurfaceOptions(), Diagnostics())


def fuzz_xodr(dice: random.Random, folder: Path) -> None:
    """Read, check and draw files of OpenDRIVE whose bytes are damaged."""
    path = folder / "area.xodr"
    sound = _small_xodr(folder)
    path.write_bytes(_damaged(sound, dice) if dice.random() < 0.5 else _rearranged(sound, dice))
    check_file(path, CheckOptions(ignore=("schema",)))
    network = read_xodr(path)
    if dice.random() < 0.5:
        write_picture(network, folder / "out.svg", PictureOptions(), "svg")
    else:
        write_geojson(network, io.BytesIO(), 0.1, 5.0)


FUZZERS: Final[dict[str, Callable[[random.Random, Path], None]]] = {
    "map": fuzz_map,
    "osm": fuzz_osm,
    "dem": fuzz_dem,
    "xodr": fuzz_xodr,
}


def run_case(fuzzer: str, seed: int) -> str:
    """Run one case in this process; return what went wrong, empty for nothing."""
    with tempfile.TemporaryDirectory(prefix="osm2xodr-fuzz-") as folder, warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            FUZZERS[fuzzer](random.Random(seed), Path(folder))
        except Osm2xodrError:
            return ""
        except Exception:
            return traceback.format_exc(limit=-4)
    return ""


def run_for(fuzzer: str, first: int, seconds: float, most: int | None = None) -> tuple[int, list[Finding]]:
    """Run a fuzzer on one seed after another in copies of this process; return how many, and what was found.

    It ends after a time, or after a number of seeds if one is given.
    """
    findings: list[Finding] = []
    end = time.monotonic() + seconds
    seed = first
    while time.monotonic() < end and (most is None or seed < first + most):
        count = min(200, max(1, int(seconds * 10)))
        done, what = _batch(fuzzer, seed, count if most is None else min(count, first + most - seed), end)
        seed += done
        if what:
            findings.append(Finding(fuzzer, seed - 1, what))
    return seed - first, findings


def _batch(fuzzer: str, first: int, count: int, end: float) -> tuple[int, str]:
    """Run seeds in one copy of the process until one fails; return how many were run, and how the last one ended."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        with contextlib.suppress(BaseException):
            _child(fuzzer, first, count, end, writer)
        os._exit(0)
    os.close(writer)
    begun, what = 0, ""
    with os.fdopen(reader, "r", encoding="utf-8", errors="replace") as stream:
        for line in stream:
            if line == "begin\n":
                begun += 1
            else:
                what += line
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        what = f"hangs for {HANG} s" if number == signal.SIGALRM else f"killed by {signal.Signals(number).name}"
    return begun, what


def _child(fuzzer: str, first: int, count: int, end: float, writer: int) -> None:
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 2)
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    for seed in range(first, first + count):
        if time.monotonic() > end:
            return
        os.write(writer, b"begin\n")
        # Ends the process from outside of Python, wherever it is.
        signal.alarm(HANG)
        what = run_case(fuzzer, seed)
        signal.alarm(0)
        if what:
            os.write(writer, what.encode("utf-8", "replace"))
            return


# ---------------------------------------------------------------- damage


def _damaged(data: bytes, dice: random.Random) -> bytes:
    """Return bytes that are cut, turned, repeated, or exchanged in a few places; sometimes as they were."""
    out = bytearray(data)
    for _ in range(dice.choice((0, 1, 1, 2, 5, 20))):
        at = dice.randrange(len(out)) if out else 0
        kind = dice.randrange(6)
        if kind == 0:
            del out[at:]
        elif kind == 1 and out:
            out[at] ^= 1 << dice.randrange(8)
        elif kind == 2:
            out[at : at + dice.randint(1, 64)] = b""
        elif kind == 3:
            out[at:at] = out[at : at + dice.randint(1, 200)]
        elif kind == 4:
            out[at : at + 4] = dice.choice(
                (b"\xff\xff\xff\xff", b"\0\0\0\0", b"\x7f\xff\xff\xff", b"\xff\xff\xff\x7f")
            )
        else:
            number = dice.choice((b"nan", b"1e309", b"-1", b"0", b"99999999999999999999", b"inf", b"", b"\xff\xfe"))
            end = next((k for k in range(at, min(at + 40, len(out))) if out[k] in b"\"'<> "), at)
            out[at:end] = number
    return bytes(out)


_ELEMENT: Final = re.compile(rb"<(\w+)[^<>]*/>")
_ATTRIBUTE: Final = re.compile(rb'(\w+)=(["\'])([^"\'<>]*)["\']')
_ODD_VALUES: Final = (
    *(b"", b"0", b"-1", b"1", b"2", b"-2", b"1e-9", b"1e9", b"1e300", b"-1e300", b"nan", b"inf", b"x", b"true"),
    *(b"99999999999", b"1e309", b"0x1", b"1 2", b"driving", b"none", b"road", b"junction", b"start", b"end"),
)


def _rearranged(data: bytes, dice: random.Random) -> bytes:
    """Return XML that is whole, but whose elements are left out, repeated, moved, or have odd or others' values."""
    for _ in range(dice.choice((1, 1, 2, 4))):
        elements = list(_ELEMENT.finditer(data))
        attributes = list(_ATTRIBUTE.finditer(data))
        if not elements or not attributes:
            return data
        one, other = dice.choice(elements), dice.choice(elements)
        kind = dice.randrange(6)
        if kind == 0:
            data = data[: one.start()] + data[one.end() :]
        elif kind == 1:
            data = data[: one.end()] + one[0] * dice.choice((1, 3, 100)) + data[one.end() :]
        elif kind == 2:
            data = data[: one.start()] + other[0] + data[one.end() :]
        else:
            at, source = dice.choice(attributes), dice.choice(attributes)
            value = dice.choice(_ODD_VALUES) if kind < 5 else source[3]
            data = data[: at.start(3)] + value + data[at.end(3) :]
    return data


def _as_pbf(text: bytes, folder: Path) -> bytes:
    import osmium

    source, target = folder / "source.osm", folder / "source.osm.pbf"
    source.write_bytes(text)
    with osmium.SimpleWriter(str(target), overwrite=True) as writer:
        for item in osmium.FileProcessor(str(source)):
            writer.add(item)
    return target.read_bytes()


@contextlib.contextmanager
def _rasterio() -> Iterator[None]:
    import rasterio

    with rasterio.Env(GDAL_PAM_ENABLED="NO"):
        yield


def _small_dem() -> bytes:
    return _remembered("dem", _make_dem)


def _make_dem() -> bytes:
    heights = np.add.outer(np.linspace(900, 1100, 24), np.linspace(0, 60, 20)).astype(np.int16)
    return _as_tiff(heights, 1.53, 42.56, 3e-4)


def _as_tiff(heights: npt.NDArray[Any], lon: float, lat: float, cell: float) -> bytes:
    """Return a GeoTIFF around a place, with cells of a size in degrees."""
    from affine import Affine
    from rasterio.io import MemoryFile

    rows, columns = heights.shape
    with _rasterio(), MemoryFile() as memory:
        transform = Affine(cell, 0, lon - cell * columns / 2, 0, -cell, lat + cell * rows / 2)
        how = {"driver": "GTiff", "width": columns, "height": rows, "count": 1, "crs": "EPSG:4326"}
        with memory.open(transform=transform, dtype=heights.dtype.name, nodata=-32768, **how) as dataset:
            dataset.write(heights, 1)
        return bytes(memory.read())


def _small_xodr(folder: Path) -> bytes:
    def make() -> bytes:
        area = folder / "sound.osm"
        area.write_text(SOUND_MAP, encoding="utf-8")
        stream = io.BytesIO()
        found = Diagnostics()
        write_xodr(convert(PipelineOptions(area), found).road_map, stream, WriteOptions(), found)
        return stream.getvalue()

    return _remembered("xodr", make)


_MEMORY: dict[str, bytes] = {}


def _remembered(name: str, make: Callable[[], bytes]) -> bytes:
    if name not in _MEMORY:
        _MEMORY[name] = make()
    return _MEMORY[name]


SOUND_MAP: Final = """<?xml version='1.0' encoding='UTF-8'?>
<osm version='0.6'>
<node id='1' lat='48.0' lon='11.0'><tag k='highway' v='traffic_signals'/></node>
<node id='2' lat='48.001' lon='11.0'/>
<node id='3' lat='48.0' lon='11.0015'/>
<node id='4' lat='47.999' lon='11.0'/>
<node id='5' lat='48.0005' lon='11.0'><tag k='highway' v='crossing'/></node>
<way id='1'><nd ref='4'/><nd ref='1'/><nd ref='5'/><nd ref='2'/><tag k='highway' v='secondary'/>
<tag k='sidewalk' v='both'/><tag k='maxspeed' v='50'/></way>
<way id='2'><nd ref='1'/><nd ref='3'/><tag k='highway' v='residential'/><tag k='sidewalk' v='both'/></way>
</osm>
"""
