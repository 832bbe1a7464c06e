"""The map that a conversion reads: a file, standard input, or an area that is cut out of one of them."""

from __future__ import annotations

import contextlib
import dataclasses
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final, NamedTuple

from osm2xodr.errors import EmptyAreaError, OptionError, Osm2xodrError
from osm2xodr.python_api.corrections import read_corrections
from osm2xodr.python_api.options import ConvertOptions, refused
from osm2xodr.system import STANDARD_OUTPUT

# Begin of the names of temporary folders.
_PREFIX: Final = "osm2xodr-"


class AreaMap(NamedTuple):
    """A map of an area and of nothing else."""

    path: Path  # The file
    options: ConvertOptions  # How to convert it
    on_stage: Callable[[str], None]  # Takes the names of stages, which may name the file


@contextlib.contextmanager
def area_map(area: Path, options: ConvertOptions, on_stage: Callable[[str], None]) -> Iterator[AreaMap]:
    """Yield the file with all of an area and nothing else.

    That is `area` itself, or a temporary file: what the options cut out of it, and what comes from standard input,
    because maps are read twice. Errors inside name what the user named.

    Raises
    ------
    OptionError
        `bbox` is none, or the options exclude each other.
    InputError
        The map or the polygons cannot be read; there is nothing to drive on in the area.
    """
    given = options.name_for(area)
    for option in ("bbox", "polygon"):
        other = "polygon" if option == "bbox" and options.polygon is not None else "frame"
        if getattr(options, option) is not None and getattr(options, other) is not None:
            raise OptionError(f"{option} and {other} exclude each other; give one of them", option, other)
    cut = options.bbox is not None or options.polygon is not None
    if not cut and area != STANDARD_OUTPUT:
        yield AreaMap(area, options, on_stage)
        return
    with tempfile.TemporaryDirectory(prefix=_PREFIX) as folder:
        path = area
        if area == STANDARD_OUTPUT:
            path = Path(folder) / "standard_input"
            with path.open("wb") as stream:
                shutil.copyfileobj(sys.stdin.buffer, stream)
        with _named_as(path, area):
            if cut:
                on_stage("cutting out the area")
                target = Path(folder) / "area.osm.pbf"
                _cut_out(path, target, options)
                path = target
        with _named_as(path, area):
            alone = options.changed(name=given, bbox=None, polygon=None, clip=False)
            yield AreaMap(path, alone, lambda stage: on_stage(stage.replace(str(path), _name(area))))


def _cut_out(source: Path, target: Path, options: ConvertOptions) -> None:
    """Cut an area out of a map, as a batch does."""
    # They load the reader of OSM files.
    from osm2xodr.batching import cut_areas
    from osm2xodr.fetching import place_of_box, place_of_file
    from osm2xodr.osmParsing import parse_ways_option

    place = place_of_box(str(options.bbox)) if options.polygon is None else place_of_file(Path(options.polygon))
    with refused("ways"):
        ways = parse_ways_option(str(options.ways))
    kept = frozenset[int]()
    if options.corrections is not None:
        kept = read_corrections(Path(options.corrections)).kept_ways()
    whole = place.cut_request(target)
    request = dataclasses.replace(
        whole, ways=ways, include_private=options.include_private, kept=kept, allow_partial=options.allow_partial
    )
    if not any(cut_areas(source, [request]).values()):
        raise EmptyAreaError(f"there is nothing to drive on in this part of {source}; give another area")


@contextlib.contextmanager
def _named_as(path: Path, given: Path) -> Iterator[None]:
    """Let errors name the file that was given in place of a temporary one."""
    try:
        yield
    except Osm2xodrError as error:
        error.args = (str(error).replace(str(path), _name(given)), *error.args[1:])
        raise


def _name(area: Path) -> str:
    """Return how users call a map."""
    return "standard input" if area == STANDARD_OUTPUT else str(area)
