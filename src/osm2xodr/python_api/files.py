"""Functions for OpenDRIVE files of any writer. Each loads what it needs when it is called."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Union

import numpy as np

from osm2xodr.defaults import CHECK_FINDINGS, RENDER_WIDTH, RENDER_WIDTH_MOST
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import InputError, OptionError
from osm2xodr.python_api.options import paths, refused
from osm2xodr.reporting import Written
from osm2xodr.surface import expand
from osm2xodr.system import STANDARD_OUTPUT, parse_json
from osm2xodr.viewing import PICTURE_COLOURS, PictureOptions, ReportOptions

if TYPE_CHECKING:
    from osm2xodr.checking import CheckResult
    from osm2xodr.opendrive import FieldValue, HasTables, OpenDrive

AnyPath = Union[str, "os.PathLike[str]"]
Box = tuple[float, float, float, float]

# The narrowest picture, pixels, in which its legend has room.
RENDER_WIDTH_LEAST: Final = 200
PICTURE_FORMATS: Final = ("svg", "png")


def check(
    file: AnyPath | HasTables,
    *,
    readers: str | Iterable[str] | None = None,
    schema: AnyPath | None = None,
    only: str | Iterable[str] = (),
    ignore: str | Iterable[str] = (),
    max_findings: int = CHECK_FINDINGS,
) -> CheckResult:
    """Check an OpenDRIVE file against the standard and what its readers stumble over.

    Parameters
    ----------
    file
        The file, or a road network.
    readers
        Names of the readers that must be able to use the file, as text with commas or one by one; none of them for
        the standard alone. By default CARLA, esmini and SUMO.
    schema
        XML schema of OpenDRIVE; by default that of ASAM's checker, if it is installed.
    only, ignore
        Names of rules: look at these alone, leave these out.
    max_findings
        Findings listed for each rule, the worst; all are counted.

    Returns
    -------
    CheckResult
        The findings; `CheckResult.headline` sums them up, `CheckResult.failed` says whether there are any.

    Raises
    ------
    OptionError
        A reader or rule is unknown.
    InputError
        The file or the schema cannot be read.
    """
    from dataclasses import replace

    from osm2xodr.checking import CheckOptions, check_drive

    options = CheckOptions(schema=None if schema is None else Path(schema))
    if readers is not None:
        with refused("readers"):
            options = replace(options, readers=names_of(readers))
    with refused("only"):
        options = replace(options, only=names_of(only))
    with refused("ignore"):
        options = replace(options, ignore=names_of(ignore))
    with refused("max_findings"):
        options = replace(options, most=max_findings)
    return check_drive(drive_of(file), options)


def locate(
    file: AnyPath | HasTables,
    *,
    lat: float | None = None,
    lon: float | None = None,
    x: float | None = None,
    y: float | None = None,
    road: str | None = None,
    s: float | None = None,
    t: float | None = None,
    lane: int | None = None,
    offset: float | None = None,
) -> list[dict[str, FieldValue]]:
    """Find a place in all coordinates of an OpenDRIVE file. Give `lat` and `lon`, `x` and `y`, or `road` and `s`.

    `Locator` finds many places at once.

    Parameters
    ----------
    file
        The file, or a road network.
    lat, lon
        Latitude and longitude, degrees, WGS 84.
    x, y
        Inertial coordinates, as in the file, m.
    road, s
        Id of a road, and distance from its start, m.
    t
        With a road: distance from the reference line to the left, m; by default 0.
    lane, offset
        With a road, instead of `t`: id of a lane, and distance from its middle to the left, m, by default 0.

    Returns
    -------
    list of dict
        All roads there, the best one first, or else the nearest one: what is known of each place by the names that
        ``docs/locate_export.md`` explains, such as ``height``, ``road``, ``lane``, ``s``; None where it is unknown.

    Raises
    ------
    OptionError
        The place is not given in one of these ways.
    InputError
        The file cannot be read, does not say where it is on Earth, or has no such road, s or lane.
    """
    from osm2xodr.opendrive import Locator

    ways = [(lat, lon), (x, y), (road, s)]
    given = [way for way in ways if way != (None, None)]
    if len(given) != 1 or None in given[0]:
        raise OptionError("give lat and lon, x and y, or road and s", "lat", "lon", "x", "y", "road", "s")
    if road is None and (t, lane, offset) != (None, None, None):
        raise OptionError("t, lane and offset go with road and s alone; leave them out", "t", "lane", "offset")
    if t is not None and (lane, offset) != (None, None):
        raise OptionError("t and lane are two ways to say the same; give one of them", "t", "lane")
    if offset is not None and lane is None:
        raise OptionError("offset counts from the middle of a lane; give lane, too", "offset", "lane")
    locator = Locator(file)
    if lat is not None and lon is not None:
        places = locator.at_geographic(lat, lon)
    elif x is not None and y is not None:
        places = locator.at_inertial(x, y)
    else:
        assert road is not None
        at, across, beside = (np.array([0.0 if item is None else item]) for item in (s, t, offset))
        places = locator.on_roads([road], at, across, [lane], beside)
    return locator.describe(places)


def report(
    file: AnyPath | HasTables,
    output: AnyPath,
    *,
    osm: AnyPath | None = None,
    dem: AnyPath | Iterable[AnyPath] = (),
    dem_crs: str | None = None,
    dem_unit: str | None = None,
    dem_encoding: str | None = None,
    report_json: AnyPath | Mapping[str, Any] | None = None,
    title: str = "",
    check: bool = True,
    scene: bool | None = None,
) -> Written:
    """Make one page of HTML to explore an OpenDRIVE file with.

    Parameters
    ----------
    file
        The file, or a road network.
    output
        Page to write; ``-`` is standard output. One that exists is replaced.
    osm
        OpenStreetMap file to hold the roads against.
    dem
        Elevation model, or several of them, to hold the heights against; patterns and folders as in `convert`.
    dem_crs, dem_unit
        CRS and unit of heights of those that do not say theirs, such as ``EPSG:25832`` and ``ft``.
    dem_encoding
        How those that are pictures code heights as colours: ``terrarium`` or ``mapbox``.
    report_json
        What the conversion reported, as a file or as read from it.
    title
        Headline; by default the name of the road network.
    check
        Whether to look for defects of the file.
    scene
        Whether the view in 3D shows the scene that `export_scene` makes, with its ground (`dem`) and buildings
        (`osm`). By default up to 250 km of roads; beyond, 3D shows lanes alone.

    Returns
    -------
    Written
        The page, its size, and what was found about the elevation models.

    Raises
    ------
    InputError
        The file or what it is compared with cannot be read, or a scene is asked for that cannot be made.
    CoverageError
        No elevation model has heights at the roads.
    OutputError
        The page cannot be written.
    """
    from osm2xodr.viewing import write_report

    log = report_json if report_json is None or isinstance(report_json, Mapping) else _read_log(Path(report_json))
    options = ReportOptions(
        None if osm is None else Path(osm),
        expand(paths(dem)),
        log,
        title,
        check,
        dem_crs,
        dem_unit,
        dem_encoding,
        scene,
    )
    diagnostics = Diagnostics()
    size = write_report(drive_of(file), Path(output), options, diagnostics)
    return Written(Path(output), size, diagnostics)


def render(
    file: AnyPath | HasTables,
    output: AnyPath,
    *,
    bbox: str | Sequence[float] | None = None,
    bbox_xy: str | Sequence[float] | None = None,
    width: int = RENDER_WIDTH,
    color: str = PICTURE_COLOURS[0],
    format: str | None = None,
) -> Written:
    """Draw an OpenDRIVE file from above, with a legend and a scale.

    Parameters
    ----------
    file
        The file, or a road network.
    output
        Picture to write; ``-`` is standard output. One that exists is replaced.
    bbox
        Draw only this: west, south, east, north, degrees, WGS 84. By default everything.
    bbox_xy
        Likewise, in x and y of the file, m.
    width
        Pixels.
    color
        What roads are coloured by: ``type`` of lane, ``height``, ``grade`` or ``speed`` limit.
    format
        ``svg`` or ``png``; by default what the name of `output` ends in.

    Returns
    -------
    Written
        The picture and its size.

    Raises
    ------
    OptionError
        An option has a value that cannot be, or contradicts another one.
    InputError
        The file cannot be read, or nothing of it can be drawn.
    OutputError
        The picture cannot be written.
    """
    if bbox is not None and bbox_xy is not None:
        raise OptionError("bbox and bbox_xy exclude each other; give one of them", "bbox", "bbox_xy")
    kind = _picture_format(Path(output), format)
    choose("color", color, PICTURE_COLOURS)
    if not RENDER_WIDTH_LEAST <= width <= RENDER_WIDTH_MOST:
        bounds = f"{RENDER_WIDTH_LEAST} to {RENDER_WIDTH_MOST:,} pixels"
        raise OptionError(f"width: {width} cannot be; give {bounds}", "width")
    box = None if bbox is None else read_box("bbox", bbox, "degrees")
    box_xy = None if bbox_xy is None else read_box("bbox_xy", bbox_xy, "metres")
    from osm2xodr.viewing import box_of_degrees, write_picture

    drive = drive_of(file)
    if box is not None:
        box_xy = box_of_degrees(drive, box)
    size = write_picture(drive, Path(output), PictureOptions(box_xy, width, color), kind)
    return Written(Path(output), size, Diagnostics())


def read_box(option: str, box: str | Sequence[float], unit: str) -> Box:
    """Return west, south, east, north, as four numbers or text with commas."""
    text = box if isinstance(box, str) else ",".join(map(str, box))
    try:
        west, south, east, north = (float(word) for word in text.split(","))
    except ValueError:
        raise OptionError(
            f"{option} {text} is not 4 numbers; write west,south,east,north in {unit}", option
        ) from None
    if not (west < east and south < north):
        raise OptionError(f"{option} {text} is empty; write west,south,east,north in {unit}", option)
    return west, south, east, north


def drive_of(file: AnyPath | HasTables) -> OpenDrive:
    """Return a file that was read already, or read it."""
    from osm2xodr.opendrive import tables_of

    return tables_of(file)


def names_of(given: str | Iterable[str]) -> tuple[str, ...]:
    """Return names, each once, that were given as text with commas or one by one."""
    words = given.split(",") if isinstance(given, str) else given
    return tuple(dict.fromkeys(word.strip() for word in words if word.strip()))


def choose(option: str, value: str, choices: Collection[str]) -> str:
    """Return the value of an option; `OptionError` if it is none of its choices."""
    if value not in choices:
        raise OptionError(f"{option}: {value!r} is unknown; choose from {', '.join(choices)}", option)
    return value


def check_sampling(tolerance: float, step: float) -> None:
    """Raise `OptionError` if curves cannot be drawn as pieces of such a tolerance and length, m."""
    for option, length in (("tolerance", tolerance), ("step", step)):
        if not 0.0 < length < math.inf:
            raise OptionError(f"{option}: {length} m is not above 0", option)


def _picture_format(output: Path, given: str | None) -> str:
    """Return the format of a picture: the one that was given, or that its file is named after."""
    if given is not None:
        return choose("format", given, PICTURE_FORMATS)
    form = output.suffix.lower().removeprefix(".")
    if form in PICTURE_FORMATS:
        return form
    if output == STANDARD_OUTPUT:
        raise OptionError(f"format: {output} has no name that tells the kind of picture; say svg or png", "format")
    raise OptionError(f"format: {output} is neither .svg nor .png; name it so, or give this option", "format")


def _read_log(path: Path) -> dict[str, Any]:
    """Read what ``convert --report-json`` wrote."""
    try:
        found = parse_json(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not JSON"
        raise InputError(f"{path}: cannot read the report of convert ({reason}); write it anew") from error
    if not isinstance(found, dict) or not isinstance(found.get("diagnostics"), list):
        raise InputError(f"{path} is not a report of convert; give the file that convert --report-json wrote")
    return found
