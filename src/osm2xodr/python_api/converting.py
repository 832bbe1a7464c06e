"""`convert`, and how its options reach the stages."""

from __future__ import annotations

import dataclasses
import difflib
import os
import shutil
import tempfile
import weakref
from collections.abc import Callable, Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from osm2xodr import pipeline
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import OptionError
from osm2xodr.furniture import FurnitureOptions
from osm2xodr.geometry import ElevationOptions, RoadOptions
from osm2xodr.model import Corrections
from osm2xodr.osmParsing import ParseOptions
from osm2xodr.pipeline import Layouts, PipelineOptions
from osm2xodr.python_api.inputs import area_map, read_corrections
from osm2xodr.python_api.network import RoadNetwork
from osm2xodr.python_api.options import (
    COPIES_FROM,
    DECLARATIONS,
    MOST_JOBS,
    ConvertOptions,
    area_name,
    paths,
    refused,
)
from osm2xodr.python_api.parts import clipping
from osm2xodr.reporting import Conversion as Made
from osm2xodr.surface import SurfaceOptions, expand
from osm2xodr.system import STANDARD_OUTPUT, available_jobs
from osm2xodr.xodrWriter import WriteOptions

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from osm2xodr.opendrive import OpenDrive
    from osm2xodr.python_api.keywords import ConvertKeywords

_Stage = TypeVar("_Stage")


class Conversion(Made, RoadNetwork):
    """A road network made of an OpenStreetMap file, as `convert` returns it, and how it was made.

    Its roads, junctions and signals are those of the file that `write` would write; they are there when asked for.
    """

    @cached_property
    def tables(self) -> OpenDrive:
        """The road network as tables."""
        from osm2xodr.opendrive import read_xodr

        # Kept as long as this: who gets the tables may read more of the file.
        folder = tempfile.mkdtemp(prefix="osm2xodr-")
        weakref.finalize(self, shutil.rmtree, folder, ignore_errors=True)
        path = Path(folder) / f"{self.options.name or 'network'}.xodr".replace("/", "_")
        self.write(path)
        return read_xodr(path)


def convert(
    area: str | os.PathLike[str],
    dem: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    output: str | os.PathLike[str] | None = None,
    options: ConvertOptions | None = None,
    *,
    on_stage: Callable[[str], None] | None = None,
    layouts: Layouts | None = None,
    **changes: Unpack[ConvertKeywords],
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
    options = changed_options(options or ConvertOptions(), {**changes})
    osm, dems = Path(area), expand(paths(dem))
    with area_map(osm, options, on_stage or (lambda stage: None)) as found:
        wanted = pipeline_options(found.path, dems, found.options)
        made = pipeline.convert(wanted, Diagnostics(), found.on_stage, layouts)
    attributions = (item.attribution for item in made.elevation_models if item.share > 0.0)
    credits = tuple(dict.fromkeys(text for text in attributions if text))
    how = _stage(WriteOptions, options, name=options.name_for(osm), elevation_credits=credits)
    source = None if osm == STANDARD_OUTPUT else osm
    inputs = options.inputs(osm, dems)
    about = {field.name: getattr(made, field.name) for field in dataclasses.fields(made)}
    about |= {"inputs": inputs, "options": how, "jobs": wanted.jobs, "source": source, "clip": clipping(options)}
    conversion = Conversion(**about)
    if output is None:
        return conversion
    return dataclasses.replace(conversion, diagnostics=conversion.write(output).diagnostics)


def changed_options(options: ConvertOptions, changes: dict[str, Any]) -> ConvertOptions:
    """Return options with some of them changed; `TypeError` if there is no such option."""
    for name in changes:
        if name not in DECLARATIONS:
            near = difflib.get_close_matches(name, DECLARATIONS, 1)
            hint = f"do you mean {near[0]!r}?" if near else "help(osm2xodr.ConvertOptions) lists all"
            raise TypeError(f"convert() has no option {name!r}; {hint}")
    # Both sides of the road are one option: what is given now counts.
    if changes.keys() & {"left_hand", "right_hand"}:
        changes = {"left_hand": None, "right_hand": None, **changes}
    return options.changed(**changes)


def pipeline_options(area: Path, dems: tuple[Path, ...], options: ConvertOptions) -> PipelineOptions:
    """Hand the options of a conversion of an OpenStreetMap file and elevation models to its stages.

    Raises
    ------
    OptionError
        A stage refuses an option.
    InputError
        The file of corrections is none; the file of areas side by side cannot be read, or does not have this one.
    """
    corrections = Corrections()
    if options.corrections is not None:
        corrections = read_corrections(Path(options.corrections), shared=options.corrections_shared)
    with refused("dem_vertical_datum"):
        surface = _stage(SurfaceOptions, options)
    for name, declared in DECLARATIONS.items():
        if declared.needs_dem and not dems and getattr(options, name) is not None:
            raise OptionError(f"{name} is about elevation models; give one with dem, or leave it out", "dem", name)
    partition = None
    if options.frame is not None:
        from osm2xodr.batching import read_partition

        own = area_name(area) if options.tile is None else options.tile
        partition = read_partition(Path(options.frame), own, in_block=options.tile is not None)
    jobs, copies_from = (options.jobs, 0) if options.jobs else (min(available_jobs(), MOST_JOBS), COPIES_FROM)
    return PipelineOptions(
        area,
        dems,
        parse=_stage(ParseOptions, options, corrections=corrections),
        surface=surface,
        elevation=_stage(ElevationOptions, options),
        roads=_stage(RoadOptions, options),
        furniture=_stage(FurnitureOptions, options),
        jobs=jobs,
        copies_from=copies_from,
        partition=partition,
        boundaries=_stage(WriteOptions, options).dialect.has_boundary,
    )


def _stage(kind: type[_Stage], options: ConvertOptions, **more: Any) -> _Stage:
    """Return the options of a stage; `more` are those of its fields that no option says."""
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        more |= options.for_stage(field)
    return kind(**more)
