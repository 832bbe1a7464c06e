"""The commands ``crop`` and ``merge``: parts of road networks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from osm2xodr.cli.options import (
    PATH,
    check_targets,
    file_argument,
    limit_options,
    output_option,
    overwrite_option,
    quiet_option,
)
from osm2xodr.system import label


@click.command(
    short_help="Cut a part out of a road network.",
    epilog="""\b
Examples:
  osm2xodr crop city.xodr --bbox 7.415,43.730,7.425,43.738 -o part.xodr
  osm2xodr crop city.xodr --polygon district.geojson -o district.xodr
  osm2xodr crop city.xodr --roads 17,18,23 -o few.xodr

Roads are cut within 1 m of the border. Junctions are kept as wholes with the ends of their arms, or left out with
their connecting roads. What is cut off and left out is said. docs/parts.md says more.

Exit status: 0 written, 1 cannot crop, 2 wrong usage, 130 interrupted.""",
)
@file_argument
@output_option("File")
@click.option("--bbox", metavar="W,S,E,N", help="Keep this: degrees, WGS 84.")
@click.option("--polygon", type=PATH, metavar="FILE", help="Likewise: the polygons of a GeoJSON file.")
@click.option("--roads", metavar="LIST", help="Keep the roads with these ids, separated by commas, as wholes.")
@overwrite_option
@quiet_option
@limit_options
def crop(file: Path, output: Path, overwrite: bool, quiet: bool, **how: Any) -> None:
    """Cut a part out of FILE, a road network in OpenDRIVE. Give one of --bbox, --polygon and --roads."""
    inputs = [file, *([how["polygon"]] if how["polygon"] else [])]
    check_targets([("-o", output)], inputs, overwrite=overwrite)
    from osm2xodr.python_api import crop as run

    lines: list[str] = []
    written = run(file, output, say=lines.append, **how)
    _echo([*lines, f"wrote {label(written)}"], quiet=quiet)


@click.command(
    short_help="Join road networks.",
    epilog="""\b
Examples:
  osm2xodr merge west.xodr east.xodr -o both.xodr

The files have the same geoReference and offset, such as those of one batch --shared-frame. Ends of roads that meet
within 1 cm, with the same heading and lanes, are linked; ids that are in use are given anew; roads that an earlier
file has are left out. docs/parts.md says more.

Exit status: 0 written, 1 cannot merge, 2 wrong usage, 130 interrupted.""",
)
@click.argument("files", nargs=-1, required=True, type=PATH)
@output_option("File")
@overwrite_option
@quiet_option
@limit_options
def merge(files: tuple[Path, ...], output: Path, overwrite: bool, quiet: bool) -> None:
    """Join FILES, road networks in OpenDRIVE of one frame, where ends of their roads meet."""
    check_targets([("-o", output)], files, overwrite=overwrite)
    from osm2xodr.python_api import merge as run

    lines: list[str] = []
    written = run(files, output, say=lines.append)
    _echo([*lines, f"wrote {label(written)}"], quiet=quiet)


def _echo(lines: list[str], *, quiet: bool) -> None:
    for line in lines if not quiet else ():
        click.echo(f"osm2xodr: {line}", err=True)
