"""`convert`, and how its options reach the stages."""

from __future__ import annotations

import dataclasses
import difflib
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Final

from osm2xodr import __version__, pipeline
from osm2xodr.conventions import TARGETS
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import OptionError
from osm2xodr.furniture import FurnitureOptions, parse_objects_option
from osm2xodr.geometry import ElevationOptions, RoadOptions, parse_grade_limits
from osm2xodr.library.corrections import read_corrections
from osm2xodr.library.maps import area_map
from osm2xodr.library.options import COPIES_FROM, DECLARATIONS, MOST_JOBS, ConvertOptions, area_name, paths, refused
from osm2xodr.library.parts import clipping
from osm2xodr.model import Corrections, Rule
from osm2xodr.osmParsing import ParseOptions, parse_ways_option
from osm2xodr.pipeline import Layouts, PipelineOptions
from osm2xodr.reporting import Conversion
from osm2xodr.surface import SurfaceOptions, expand
from osm2xodr.system import STANDARD_OUTPUT, available_jobs
from osm2xodr.xodrWriter import WriteOptions

# Options that mean nothing without an elevation model.
_NEED_DEM: Final = (
    *("vertical_datum", "dem_vertical_datum", "dem_sigma", "dem_crs", "dem_unit", "dem_encoding"),
    "fail_below_coverage",
)


def convert(
    area: str | os.PathLike[str],
    dem: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    output: str | os.PathLike[str] | None = None,
    options: ConvertOptions | None = None,
    *,
    on_stage: Callable[[str], None] | None = None,
    layouts: Layouts | None = None,
    **changes: Any,
) -> Conversion:
    """Turn an OpenStreetMap file and elevation models into an OpenDRIVE road network.

    The same input gives the same bytes as ``osm2xodr convert``, on any machine and with any number of processes.

    Parameters
    ----------
    area
        OpenStreetMap file: ``.osm`` or ``.osm.pbf``, also packed by gzip, bzip2, xz, zip or (Python 3.14) zstd.
    dem
        Elevation model, or several of them: files, patterns such as ``dem/*.tif`` and folders of GeoTIFF, HGT, ASC,
        IMG, VRT or zip archives, in any coordinate reference system. Without any the world is flat, at height 0.
    output
        File to write; one that exists is replaced. None writes nothing: `Conversion.write` does so later.
    options
        How to convert.
    on_stage
        Called with the name of each stage as it begins.
    layouts
        Keeps the roads of a block of areas side by side (option `tile`) for the next of them.
    **changes
        Options that differ from those in `options`, by the names of `ConvertOptions`, which are those of the command
        line: ``ways="major"``, ``target="sumo"``, ``max_grade={"motorway": 0.05}``, ``left_hand=True`` and so on.

    Returns
    -------
    Conversion
        The road network, with figures and with what was guessed, dropped and repaired.

    Raises
    ------
    TypeError
        An option is unknown.
    OptionError
        An option has a value that cannot be, or contradicts another one.
    InputError
        A file cannot be read or is not what it should be; there is nothing to drive on in the area.
    CoverageError
        The elevation models do not reach where the roads are.
    OutputError
        The file cannot be written.

    Examples
    --------
    >>> import osm2xodr
    >>> network = osm2xodr.convert("area.osm", dem="dem.tif", ways="major")  # doctest: +SKIP
    >>> network.write("area.xodr")  # doctest: +SKIP
    """
    options = _changed(options or ConvertOptions(), changes)
    osm, dems = Path(area), expand(paths(dem))
    with area_map(osm, options, on_stage or (lambda stage: None)) as found:
        wanted = pipeline_options(found.path, dems, found.options)
        made = pipeline.convert(wanted, Diagnostics(), found.on_stage, layouts)
    owed = (item.attribution for item in made.elevation_models if item.share > 0.0)
    how = WriteOptions(
        options.xodr_version,
        options.name_for(osm),
        options.date,
        __version__,
        target=wanted.furniture.target,
        elevation_credits=tuple(dict.fromkeys(text for text in owed if text)),
    )
    source = None if osm == STANDARD_OUTPUT else osm
    inputs = options.inputs(osm, dems)
    conversion = dataclasses.replace(
        made, inputs=inputs, options=how, jobs=wanted.jobs, source=source, clip=clipping(options)
    )
    if output is None:
        return conversion
    return dataclasses.replace(conversion, diagnostics=conversion.write(output).diagnostics)


def _changed(options: ConvertOptions, changes: dict[str, Any]) -> ConvertOptions:
    """Return options with some of them changed."""
    for name in changes:
        if name not in DECLARATIONS:
            near = difflib.get_close_matches(name, DECLARATIONS, 1)
            hint = f"do you mean {near[0]!r}?" if near else "help(osm2xodr.ConvertOptions) lists all"
            raise TypeError(f"convert() has no option {name!r}; {hint}")
    # Both sides of the road are one option: what is given now counts.
    if changes.keys() & {"left_hand", "right_hand"}:
        changes = {"left_hand": None, "right_hand": None, **changes}
    return dataclasses.replace(options, **changes)


def pipeline_options(area: Path, dems: tuple[Path, ...], options: ConvertOptions) -> PipelineOptions:
    """Hand the options of a conversion of an OpenStreetMap file and elevation models to its stages.

    Raises
    ------
    OptionError
        A stage refuses an option.
    InputError
        The file of corrections is none; the file of areas side by side cannot be read, or does not have this one.
    """
    with refused("objects"):
        extra = frozenset[str]() if options.objects is None else parse_objects_option(str(options.objects))
    furniture = FurnitureOptions(TARGETS[options.target], extra, enabled=not options.no_furniture)
    with refused("ways"):
        ways = parse_ways_option(str(options.ways))
    corrections = Corrections()
    if options.corrections is not None:
        corrections = read_corrections(Path(options.corrections), shared=options.corrections_shared)
    rule = None if options.left_hand is None else Rule.LEFT_HAND if options.left_hand else Rule.RIGHT_HAND
    with refused("default_lane_width"):
        parse = ParseOptions(
            ways,
            options.include_private,
            rule,
            options.default_lane_width,
            furniture=furniture.enabled,
            extra_objects=furniture.extra_objects,
            default_speeds=not options.no_default_speeds,
            allow_partial=options.allow_partial,
            corrections=corrections,
            guessed_sidewalks=not options.no_guessed_sidewalks,
            guessed_shoulders=not options.no_guessed_shoulders,
        )
    surface = SurfaceOptions(
        options.surface,
        options.polynomial_order,
        options.allow_partial,
        dem_type=options.dem_type,
        dem_crs=options.dem_crs,
        dem_unit=options.dem_unit,
        dem_encoding=options.dem_encoding,
        coverage_least=options.fail_below_coverage,
    )
    with refused("dem_sigma"):
        surface = dataclasses.replace(surface, sigma=options.dem_sigma)
    with refused("dem_vertical_datum"):
        surface = dataclasses.replace(
            surface, vertical_datum=options.vertical_datum, dem_vertical_datum=options.dem_vertical_datum
        )
    for name in () if dems else _NEED_DEM:
        if getattr(options, name) is not None:
            raise OptionError(f"{name} is about elevation models; give one with dem, or leave it out", "dem", name)
    elevation = ElevationOptions(
        options.smoothing, structures=not options.no_structures, superelevation=options.superelevation
    )
    with refused("max_grade"):
        if options.max_grade is not None:
            elevation = dataclasses.replace(elevation, grade_limit=parse_grade_limits(str(options.max_grade)))
    partition = None
    if options.frame is not None:
        from osm2xodr.batch import read_partition

        own = area_name(area) if options.tile is None else options.tile
        partition = read_partition(Path(options.frame), own, in_block=options.tile is not None)
    jobs, copies_from = (options.jobs, 0) if options.jobs else (min(available_jobs(), MOST_JOBS), COPIES_FROM)
    roads = RoadOptions(options.turnarounds, options.u_turns, options.plan)
    boundaries = WriteOptions(options.xodr_version).dialect.has_boundary
    return PipelineOptions(
        area, dems, parse, surface, elevation, roads, furniture, jobs, copies_from, partition, boundaries
    )
