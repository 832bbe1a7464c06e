"""The options of ``convert`` as click hands them over, and what the stages want of them."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from osm2xodr import __version__
from osm2xodr.cli import defaults
from osm2xodr.conventions import TARGETS
from osm2xodr.errors import InputError
from osm2xodr.furniture import FurnitureOptions, parse_objects_option

if TYPE_CHECKING:
    from osm2xodr.pipeline import ConvertOptions


@dataclasses.dataclass(frozen=True)
class Arguments:
    """The options of ``convert`` as click hands them over."""

    area: Path
    dem: tuple[Path, ...]
    output: Path
    overwrite: bool
    name: str | None
    date: str
    ways: str
    include_private: bool
    xodr_version: str
    left_hand: bool
    right_hand: bool
    default_lane_width: float | None
    surface: str
    polynomial_order: int
    dem_type: str
    dem_sigma: float | None
    vertical_datum: str | None
    dem_vertical_datum: str | None
    allow_partial: bool
    smoothing: float
    max_grade: str | None
    no_structures: bool
    superelevation: bool
    turnarounds: bool
    target: str
    objects: str | None
    no_furniture: bool
    report_json: Path | None
    check: bool
    html: Path | None
    frame: Path | None
    jobs: int | None
    verbose: int
    quiet: bool


def convert_options(arguments: Arguments) -> ConvertOptions:
    """Turn options into those of the stages."""
    from osm2xodr.geometry import ElevationOptions, RoadOptions, parse_grade_limits
    from osm2xodr.model import Rule
    from osm2xodr.osmParsing import ParseOptions, parse_ways_option
    from osm2xodr.pipeline import ConvertOptions
    from osm2xodr.surface import SurfaceOptions
    from osm2xodr.system import available_jobs

    furniture = _furniture_options(arguments)
    rule = Rule.LEFT_HAND if arguments.left_hand else Rule.RIGHT_HAND if arguments.right_hand else None
    with _usage("--ways"):
        ways = parse_ways_option(arguments.ways)
    with _usage("--default-lane-width"):
        parse = ParseOptions(
            ways,
            arguments.include_private,
            rule,
            arguments.default_lane_width,
            furniture=furniture.enabled,
            extra_objects=furniture.extra_objects,
        )
    with _usage("--dem-sigma, --dem-vertical-datum"):
        surface = SurfaceOptions(
            method=arguments.surface,
            polynomial_order=arguments.polynomial_order,
            allow_partial=arguments.allow_partial,
            sigma=arguments.dem_sigma,
            dem_type=arguments.dem_type,
            vertical_datum=arguments.vertical_datum,
            dem_vertical_datum=arguments.dem_vertical_datum,
        )
    if not 0.0 < arguments.smoothing < math.inf:
        raise click.UsageError(f"--smoothing: {arguments.smoothing:g} is not above 0; 1 is the usual, 2 is smoother")
    elevation = ElevationOptions(
        arguments.smoothing, structures=not arguments.no_structures, superelevation=arguments.superelevation
    )
    if arguments.max_grade is not None:
        with _usage("--max-grade"):
            elevation = dataclasses.replace(elevation, grade_limit=parse_grade_limits(arguments.max_grade))
    partition = None
    if arguments.frame is not None:
        from osm2xodr.batch import read_partition

        partition = read_partition(arguments.frame, area_name(arguments.area))
    return ConvertOptions(
        arguments.area,
        arguments.dem,
        parse,
        surface,
        elevation,
        RoadOptions(arguments.turnarounds),
        furniture,
        arguments.jobs or min(available_jobs(), defaults.MOST_JOBS),
        partition,
    )


def _furniture_options(arguments: Arguments) -> FurnitureOptions:
    with _usage("--objects"):
        extra = parse_objects_option(arguments.objects) if arguments.objects is not None else frozenset()
    return FurnitureOptions(TARGETS[arguments.target], extra, enabled=not arguments.no_furniture)


@contextlib.contextmanager
def _usage(option: str) -> Iterator[None]:
    """Turn the refusal of an option's value into wrong usage."""
    try:
        yield
    except (ValueError, InputError) as error:
        raise click.UsageError(f"{option}: {error}") from error


def report_inputs(arguments: Arguments, name: str) -> dict[str, Any]:
    """Return what was asked for, for the report."""
    return {
        "osm2xodr": __version__,
        "area": str(arguments.area),
        "dem": [str(path) for path in arguments.dem],
        "name": name,
        "ways": arguments.ways,
        "include_private": arguments.include_private,
        "left_hand": True if arguments.left_hand else False if arguments.right_hand else None,
        "default_lane_width": arguments.default_lane_width,
        "surface": arguments.surface,
        "polynomial_order": arguments.polynomial_order,
        "dem_type": arguments.dem_type,
        "dem_sigma": arguments.dem_sigma,
        "vertical_datum": arguments.vertical_datum,
        "dem_vertical_datum": arguments.dem_vertical_datum,
        "allow_partial": arguments.allow_partial,
        "smoothing": arguments.smoothing,
        "max_grade": arguments.max_grade,
        "structures": not arguments.no_structures,
        "superelevation": arguments.superelevation,
        "turnarounds": arguments.turnarounds,
        "target": arguments.target,
        "objects": arguments.objects,
        "furniture": not arguments.no_furniture,
        **({"frame": str(arguments.frame)} if arguments.frame is not None else {}),
    }


def area_name(area: Path) -> str:
    """Return the name of a file without the endings of OSM files."""
    name = area.name
    for ending in (".gz", ".bz2", ".osm", ".pbf", ".xml", ".osm"):
        name = name.removesuffix(ending)
    return name
