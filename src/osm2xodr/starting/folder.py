"""The function ``start``: convert, export, and what a simulator needs beside that, in one folder."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import shlex
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from osm2xodr import __version__
from osm2xodr.errors import OptionError
from osm2xodr.python_api import ConvertOptions, area_map, changed_options, clipping, convert
from osm2xodr.starting import autoware, carla, esmini, sumo
from osm2xodr.starting.request import FOLDER, NOT_CHOSEN, SIMULATORS, TARGET_OF, XODR, Made, Request
from osm2xodr.surface import expand
from osm2xodr.system import FILES_KEY, STANDARD_OUTPUT, atomic_folder, check_folder, record

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from osm2xodr.python_api import ConvertKeywords
    from osm2xodr.reporting import Conversion, Written

# The file by which such a folder is known, with the names of all others.
INDEX: Final = "start.json"
_README: Final = "README.md"
_MAKERS: Final[Mapping[str, Callable[[Request], Made]]] = MappingProxyType(
    {"carla": carla.make, "sumo": sumo.make, "esmini": esmini.make, "autoware": autoware.make}
)
_TITLES: Final = MappingProxyType({"carla": "CARLA", "sumo": "SUMO", "esmini": "esmini", "autoware": "Autoware"})
_CREDIT: Final = """\
Road network: © [OpenStreetMap contributors](https://www.openstreetmap.org/copyright), under the Open Database License
1.0 (ODbL), which what is made of it has to keep, and name them."""


@record
class Started:
    """A folder that a simulator runs."""

    simulator: str
    folder: Path
    files: tuple[Path, ...]
    command: str  # Starts the simulator with it, in a shell, from the current folder
    notes: tuple[str, ...]  # What is good to know before, sentences without a full stop
    conversion: Conversion  # The road network
    written: Written  # Its file, with all that was guessed, dropped and repaired


def start(
    simulator: str,
    area: str | os.PathLike[str],
    folder: str | os.PathLike[str],
    dem: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    options: ConvertOptions | None = None,
    *,
    scene_tile: float | None = None,
    on_stage: Callable[[str], None] | None = None,
    **changes: Unpack[ConvertKeywords],
) -> Started:
    """Make a folder that a simulator runs: an area as a road network, and what drives on it.

    Parameters
    ----------
    simulator
        ``carla``, ``sumo``, ``esmini`` or ``autoware``.
    area, dem
        Map and elevation models, as of `convert`.
    folder
        Folder to write. Of one that was written by this function before its files are replaced; all others stay.
    options
        How to convert; the target follows from the simulator.
    scene_tile
        Width of the tiles of CARLA's scene, m; by default one tile up to 2.5 km, and tiles of 2 km above.
    on_stage
        Called with the name of each stage as it begins.
    **changes
        Options that differ from those in `options`, as of `convert`.

    Returns
    -------
    Started
        The folder and its files, the command that runs it, and what is good to know before.

    Raises
    ------
    TypeError
        An option is unknown.
    OptionError
        The simulator is unknown; an option has a value that cannot be, or is none of this simulator.
    InputError
        A file cannot be read; there is nothing to drive on; what makes the folder is not installed.
    CoverageError
        The elevation models do not reach where the roads are.
    OutputError
        The folder cannot be written, or has other files in it.

    Examples
    --------
    >>> import osm2xodr
    >>> print(osm2xodr.start("sumo", "area.osm", "area_sumo", dem="dem.tif").command)  # doctest: +SKIP
    sumo-gui -c area_sumo/map.sumocfg
    """
    if simulator not in SIMULATORS:
        raise OptionError(f"simulator: {simulator!r} is unknown; choose from {', '.join(SIMULATORS)}", "simulator")
    if scene_tile is not None and simulator != "carla":
        raise OptionError("scene_tile is about CARLA; leave it out", "scene_tile")
    for name in sorted(NOT_CHOSEN & changes.keys()):
        raise OptionError(f"{name} is not for this: the simulator decides, or a batch does; leave it out", name)
    how = changed_options(options or ConvertOptions(), {**changes, "target": TARGET_OF[simulator]})
    source, dems, target = Path(area), expand((dem,) if isinstance(dem, (str, os.PathLike)) else dem), Path(folder)
    inputs = [*([] if source == STANDARD_OUTPUT else [source]), *dems]
    check_folder(target, INDEX, inputs)
    say = on_stage or (lambda stage: None)
    with area_map(source, how, say) as found, atomic_folder(target, INDEX, inputs) as place:
        made = convert(found.path, dems, options=found.options, on_stage=found.on_stage)
        conversion = dataclasses.replace(made, inputs=how.inputs(source, dems), clip=clipping(how))
        say(f"writing {XODR}")
        written = conversion.write(place / XODR)
        about = {name: getattr(how, name) for name in ("dem_crs", "dem_unit", "dem_encoding")}
        request = Request(
            *(conversion, found.path, dems, about, place, _name(how.name_for(source)), scene_tile, found.on_stage)
        )
        ready = _MAKERS[simulator](request)
        (place / _README).write_text(_readme(simulator, request, ready), encoding="utf-8")
        names = _index(simulator, place, ready.command)
    command = ready.command.replace(FOLDER, shlex.quote(os.fspath(target)))
    files = tuple(target / name for name in names)
    written = dataclasses.replace(written, path=target / XODR)
    return Started(simulator, target, files, command, ready.notes, conversion, written)


def _name(text: str) -> str:
    """Return a name of letters, digits and underscores, which all simulators take."""
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    return re.sub(r"\W+", "_", plain).strip("_") or "map"


def _index(simulator: str, place: Path, command: str) -> list[str]:
    """Write the file that lists all others, and return the names of all."""
    names = sorted(item.relative_to(place).as_posix() for item in place.rglob("*") if item.is_file())
    document = {"generator": f"osm2xodr {__version__}", "simulator": simulator, "command": command, FILES_KEY: names}
    (place / INDEX).write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    return [*names, INDEX]


def _readme(simulator: str, request: Request, made: Made) -> str:
    """Return what tells people about the folder."""
    table = {XODR: "the road network, OpenDRIVE", **made.files, INDEX: "names what was written here"}
    rows = "\n".join(f"| `{name}` | {text} |" for name, text in table.items())
    credits = "\n\n".join([_CREDIT, *(f"Heights: {text}." for text in request.conversion.options.elevation_credits)])
    parts = [
        f"# {request.name}, for {_TITLES[simulator]}",
        f"{made.needs} Then, in this folder:",
        f"    {made.command.replace(FOLDER, '.')}",
        *(["\n".join(f"* {note[:1].upper()}{note[1:]}." for note in made.notes)] if made.notes else []),
        *(f"## {heading}\n\n{text}" for heading, text in made.sections.items()),
        f"## Files\n\n| file | what it is |\n|---|---|\n{rows}",
        f"## Licence\n\n{credits}",
        f"Made by osm2xodr {__version__}.",
    ]
    return "\n\n".join(parts) + "\n"
