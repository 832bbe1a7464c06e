"""The command ``fetch``: gets the data of an area."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from osm2xodr.cli.options import PATH, Parsed, limit_options, overwrite_option, quiet_option
from osm2xodr.diagnostics import counted
from osm2xodr.fetching import (
    CACHE_AGE,
    DOWNLOAD_MAX,
    ELEVATION_MODEL,
    GEOCODER,
    OVERPASS_SERVERS,
    PATIENCE,
    RETRIES,
)
from osm2xodr.system import Progress, parse_duration

if TYPE_CHECKING:
    from osm2xodr.fetching import FetchedArea

_MEGABYTE: Final = 1e6
_DURATION: Final = Parsed("duration", parse_duration)


@click.command(
    short_help="Get map and elevation model of an area.",
    epilog="""\b
Examples:
  osm2xodr fetch --bbox 1.545,42.545,1.605,42.575 -o ordino
  osm2xodr fetch --place "Ordino, Andorra" -o ordino
  osm2xodr fetch --place town.geojson -o town --dem-model swissalti3d --dem-model copernicus-glo30
  osm2xodr fetch --bbox 1.545,42.545,1.605,42.575 -o ordino --extract andorra.osm.pbf
  osm2xodr fetch --list-models

Writes area.osm, dem.tif and SOURCES.md, and goes on where it ended when it is started again.

Exit status: 0 written, 1 cannot fetch, 2 wrong usage, 130 interrupted.""",
)
@click.option("--bbox", metavar="W,S,E,N", help="Area: degrees, WGS 84.")
@click.option(
    "--place",
    metavar="NAME|FILE",
    help="Area: the box of a place that the geocoder finds by its name, or polygons in GeoJSON.",
)
@click.option(
    "--geocoder", default=GEOCODER, show_default=True, metavar="URL", help="Geocoder with the API of Nominatim."
)
@click.option("-o", "--output", type=PATH, metavar="DIR", help="Folder to write to.  [required]")
@click.option(
    "--extract",
    metavar="FILE|URL",
    help="Cut the map out of this one, which is downloaded once.  [default: ask the Overpass API]",
)
@click.option(
    "--overpass",
    multiple=True,
    metavar="URL",
    help=f"Server of the Overpass API.  May be repeated: the next one is asked where one fails.  [default: "
    f"{', '.join(OVERPASS_SERVERS)}]",
)
@click.option(
    "--dem-model",
    multiple=True,
    metavar="NAME",
    help=f"Elevation model, the preferred one first.  May be repeated.  [default: {ELEVATION_MODEL}]",
)
@click.option("--list-models", is_flag=True, help="List the elevation models, and end.")
@click.option(
    "--dem-models", multiple=True, type=PATH, metavar="FILE", help="Table of further models.  May be repeated."
)
@click.option("--dem-url", metavar="URL", help="Take the elevation model from there, as the table writes addresses.")
@click.option("--no-osm", is_flag=True, help="Fetch no map.")
@click.option("--no-dem", is_flag=True, help="Fetch no elevation model.")
@click.option(
    "--no-surroundings",
    is_flag=True,
    help="Fetch no buildings and no water, which only scenes and the 3D view of reports show.",
)
@click.option(
    "--allow-partial", is_flag=True, help="Take what there is of an --extract that its server did not send in full."
)
@click.option("--pbf", is_flag=True, help="Write area.osm.pbf instead of area.osm.")
@click.option(
    "--cache",
    type=PATH,
    metavar="DIR",
    help="Folder for what was received.  [default: osm2xodr in $XDG_CACHE_HOME or ~/.cache]",
)
@click.option(
    "--max-age",
    type=_DURATION,
    default=f"{CACHE_AGE / 3600.0:g}h",
    show_default=True,
    metavar="TIME",
    help="How old a map in the cache may be.",
)
@click.option("--refresh", is_flag=True, help="Take nothing from the cache.")
@click.option(
    "--max-download",
    type=click.FloatRange(min=0.0, min_open=True),
    default=DOWNLOAD_MAX / _MEGABYTE,
    show_default=True,
    metavar="MB",
    help="Largest file to download whole.",
)
@click.option(
    "--patience",
    type=_DURATION,
    default=f"{PATIENCE:g}s",
    show_default=True,
    metavar="TIME",
    help="How long a server may be silent or slow.",
)
@click.option(
    "--retries",
    type=click.IntRange(0, 20),
    default=RETRIES,
    show_default=True,
    help="How often to ask again where a server is busy or a connection cut.",
)
@overwrite_option
@quiet_option
@limit_options
def fetch(**options: Any) -> None:
    """Get the map of an area from OpenStreetMap, and elevation models of it, ready to convert."""
    if options["list_models"]:
        _list_models(options["dem_models"])
        return
    if options["output"] is None:
        raise click.UsageError("Missing option '-o' / '--output'.")
    quiet = options.pop("quiet")
    del options["list_models"]
    progress = _Progress(quiet=quiet)
    from osm2xodr.python_api import fetch as run

    try:
        area = run(**options, say=progress.note, progress=progress.show)
    finally:
        progress.clear()
    if not quiet:
        _report(area, options["output"])


class _Progress:
    """Says on standard error what is done, with share and time left, and why there is a wait."""

    def __init__(self, *, quiet: bool) -> None:
        self._quiet = quiet
        self._line = Progress(sys.stderr, quiet=quiet)
        # What is done, and since when.
        self._task = ("", 0.0)

    def show(self, task: str, state: str = "", share: float | None = None) -> None:
        """Show what is done at the moment, its state and what share of it is done."""
        if task != self._task[0]:
            self._task = (task, self._line.now())
        self._line.show(f"{task}: {state}" if state else task, share, self._task[1])

    def note(self, text: str) -> None:
        """Print a line."""
        self.clear()
        if not self._quiet:
            click.echo(f"osm2xodr: {text}", err=True)

    def clear(self) -> None:
        """Clear the line that is rewritten."""
        self._line.clear()


def _list_models(files: tuple[Path, ...]) -> None:
    """Print the elevation models."""
    from osm2xodr.fetching import read_models

    for model in read_models(files).values():
        kind = "with canopy and roofs" if model.covered else "ground"
        click.echo(f"{model.name:24} {model.cell:4g} m  {kind:21}  {model.title}; {model.licence}")
        if model.by_hand:
            click.echo(f"{'':33}by hand: {model.by_hand} ({model.page})")


def _report(area: FetchedArea, output: Path) -> None:
    """Print what was written, and how to go on."""
    lines = []
    if area.osm is not None:
        date = f", data of {area.osm.date}" if area.osm.date else ""
        lines.append(f"wrote {area.osm.path} ({_size(area.osm.path)}{date})")
    for item in area.models:
        for path in item.paths:
            lines.append(f"wrote {path} ({_size(path)}): {item.model.title}")
        if item.absent:
            files = "a further file" if item.absent == 1 else counted(item.absent, "further file")
            lines.append(f"{item.model.title} has no {files} of the area: sea, or beyond where it was made")
        if item.voids > 0.0:
            lines.append(f"{item.model.title}: up to {100.0 * item.voids:.2g} % of the cells have no height")
    lines.append(f"sources and licences, which those who pass results on must name, are in {area.sources}")
    if area.osm is not None:
        dems = "".join(f" --dem {shlex.quote(str(path))}" for path in area.dems)
        target = shlex.quote(str(output / "area.xodr"))
        lines.append(f"go on with: osm2xodr convert {shlex.quote(str(area.osm.path))}{dems} -o {target}")
    for line in lines:
        click.echo(f"osm2xodr: {line}", err=True)


def _size(path: Path) -> str:
    return f"{path.stat().st_size / _MEGABYTE:,.2f} MB"
