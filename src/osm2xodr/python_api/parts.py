"""The functions ``crop`` and ``merge``. They load what they need when they are called."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from osm2xodr.errors import EmptyAreaError, InputError, OptionError
from osm2xodr.system import STANDARD_OUTPUT, stream_to

if TYPE_CHECKING:
    from osm2xodr.crop_and_merge import Choice
    from osm2xodr.model import BoolArray, FloatArray
    from osm2xodr.opendrive import OpenDrive
    from osm2xodr.python_api.files import AnyPath, Box
    from osm2xodr.python_api.options import ConvertOptions

_Listener = Callable[[str], None]


def crop(
    file: AnyPath,
    output: AnyPath,
    *,
    bbox: str | Sequence[float] | None = None,
    polygon: AnyPath | None = None,
    roads: str | Iterable[str] | None = None,
    say: _Listener | None = None,
) -> Path:
    """Cut a part out of an OpenDRIVE file of any writer. Give one of `bbox`, `polygon` and `roads`.

    Parameters
    ----------
    file
        The file, plain or packed by gzip.
    output
        File to write; ``-`` is standard output. One that exists is replaced.
    bbox
        West, south, east, north, degrees, WGS 84.
    polygon
        GeoJSON file with polygons.
    roads
        Ids of roads, as text with commas or one by one; each is kept as a whole.
    say
        Is called with each sentence about what was cut off or left out.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    OptionError
        An option has a value that cannot be, or not exactly one is given.
    InputError
        A file cannot be read, or does not say where it is on Earth.
    EmptyAreaError
        Nothing of the file is in this part.
    OutputError
        The file cannot be written.
    """
    if sum(item is not None for item in (bbox, polygon, roads)) != 1:
        raise OptionError("give one of bbox, polygon and roads", "bbox", "polygon", "roads")
    from osm2xodr.crop_and_merge import crop_network
    from osm2xodr.python_api.files import read_box

    box = None if bbox is None else read_box("bbox", bbox, "degrees")
    drive = _read_again(file)
    choice = _choice(drive, box, None if polygon is None else Path(polygon), roads)
    return _write(Path(output), *crop_network(drive, choice), say)


def clipping(options: ConvertOptions) -> Callable[[Path, Any], Iterable[str]] | None:
    """Return what cuts off a file that was written at the part of the map that the options name; None for the whole.

    It writes to a binary stream, and returns sentences about what was cut off.
    """
    if not options.clip:
        return None

    def clip(path: Path, stream: Any) -> Iterable[str]:
        from osm2xodr.crop_and_merge import crop_network, write_tree
        from osm2xodr.opendrive import read_xodr
        from osm2xodr.python_api.files import read_box

        drive = read_xodr(path)
        box = None if options.bbox is None else read_box("bbox", options.bbox, "degrees")
        polygon = None if options.polygon is None else Path(options.polygon)
        choice = _choice(drive, box, polygon, None)
        if not choice.stretches:
            raise EmptyAreaError("clip leaves no road: all of them lie outside of the part; give a larger one")
        root, lines = crop_network(drive, choice)
        write_tree(root, stream)
        return lines

    return clip


def merge(files: Iterable[AnyPath], output: AnyPath, *, say: _Listener | None = None) -> Path:
    """Join OpenDRIVE files of one frame where ends of their roads meet.

    Parameters
    ----------
    files
        Two files or more, plain or packed by gzip, with the same geoReference and offset.
    output
        File to write; ``-`` is standard output. One that exists is replaced.
    say
        Is called with each sentence about what was joined, renamed or left out.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    InputError
        A file cannot be read, or the files are not of one frame.
    OutputError
        The file cannot be written.
    """
    drives = [_read_again(file) for file in files]
    if len(drives) < 2:
        raise OptionError("files: merge needs two or more", "files")
    from osm2xodr.crop_and_merge import merge_networks

    return _write(Path(output), *merge_networks(drives), say)


def _write(output: Path, root: Any, lines: Iterable[str], say: _Listener | None) -> Path:
    """Write a document, and pass on the sentences about it."""
    from osm2xodr.crop_and_merge import write_tree

    with stream_to(output) as stream:
        write_tree(root, stream)
    if say is not None:
        for line in lines:
            say(line)
    return output


def _read_again(file: AnyPath) -> OpenDrive:
    """Read a file that will be read once more, as a tree."""
    if os.fspath(file) == str(STANDARD_OUTPUT):
        raise InputError("standard input cannot be read twice, as is needed here; give a file")
    from osm2xodr.opendrive import read_xodr

    return read_xodr(Path(file))


def _choice(drive: OpenDrive, box: Box | None, polygon: Path | None, roads: str | Iterable[str] | None) -> Choice:
    """Return what is kept of a file."""
    from osm2xodr.crop_and_merge import choose_inside, choose_roads
    from osm2xodr.python_api.files import names_of

    if roads is not None:
        names = frozenset(names_of(roads))
        unknown = sorted(names - set(drive.roads.id))
        if unknown:
            raise OptionError(f"roads: {drive.path} has no road {unknown[0]!r}", "roads")
        return choose_roads(drive, names)
    from osm2xodr.opendrive import frame_of

    frame, reason = frame_of(drive.header)
    if frame is None:
        raise InputError(f"{drive.path}: {reason}; choose roads by their ids")
    if box is not None:
        west, south, east, north = box
        rings: list[Sequence[tuple[float, float]]] = [((west, south), (east, south), (east, north), (west, north))]
    else:
        from osm2xodr.batching import read_polygons

        assert polygon is not None
        rings = [ring for _, found in read_polygons(polygon) for ring in found]
    from osm2xodr.curves import inside_outline
    from osm2xodr.model import Outline

    outline = Outline(tuple(np.array(ring, np.float64) for ring in rings))

    def inside(x: FloatArray, y: FloatArray) -> BoolArray:
        return inside_outline(outline, *frame.to_geographic(x, y))

    return choose_inside(drive, inside)
