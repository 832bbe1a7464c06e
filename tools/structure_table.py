#!/usr/bin/env python3
"""Writes docs/method/structures.md: bridges and tunnels of four places with their clearances and grades.

    python tools/structure_table.py SCENES [--least METRES] > docs/method/structures.md

SCENES is a folder of places, each a folder with area.osm and dem.tif.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import tolerated_grade
from osm2xodr.model import StructureRecord
from osm2xodr.pipeline import PipelineOptions, convert

HEAD = """# Appendix: bridges and tunnels of four places

Made by `tools/structure_table.py`; bridges and tunnels shorter than {least:g} m that cross no road are left out.
Clearance is the height from road to road where it is least. `*` marks grades above 1.25 times the limit of the class,
which the report of a conversion names as well. A chain that junctions divide has a row for each part. How the heights
are found: [heights.md](heights.md). Data: © OpenStreetMap contributors."""
COLUMNS = "| structure | OSM way | length, m | above the ground, m | clearance, m | largest grade | limit |"


@dataclass(frozen=True, slots=True)
class Place:
    """A place in the appendix."""

    folder: str
    title: str
    text: str


PLACES = (
    Place(
        "monaco",
        "Monaco",
        "Dense, steep, most of it tunnels. Elevation model: SRTM with added errors, 30 m.",
    ),
    Place(
        "badwildbad",
        "Bad Wildbad",
        "Elevation model: laser, 13 m; GeoBasis data of LGL Baden-Württemberg, dl-de/by-2-0.",
    ),
    Place(
        "portland_interchange",
        "Portland",
        "An interchange with decks above each other. Elevation model: USGS NED, 10 m.",
    ),
    Place(
        "andorra_ordino",
        "Ordino (Andorra)",
        "Serpentines. Elevation model: SRTM, 90 m. Way 470698111 is a hairpin below a bridge of its own upper arm;\n"
        "cells of 90 m do not resolve the two.",
    ),
)


def rows(structures: tuple[StructureRecord, ...], least: float) -> Iterator[str]:
    """Yield the lines of the table, for structures of a least length (m) and all that cross a road."""
    yield COLUMNS
    yield "|---|---|---:|---:|---:|---:|---:|"
    for record in structures:
        if record.length < least and record.clearance is None:
            continue
        ways = ", ".join(str(way) for way in record.osm_way_ids)
        above = "" if record.above_ground is None else f"{record.above_ground:.1f}"
        clearance = "" if record.clearance is None else f"{record.clearance:.1f} (way {record.crossed_way})"
        steep = " *" if record.grade > tolerated_grade(record.grade_limit) else ""
        yield (
            f"| {record.kind} | {ways} | {record.length:.0f} | {above} | {clearance} "
            f"| {100 * record.grade:.1f} %{steep} | {100 * record.grade_limit:.0f} % |"
        )


def main() -> None:
    """Convert the places and print the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", type=Path)
    parser.add_argument("--least", type=float, default=20.0, help="leave out shorter ones that cross no road, m")
    arguments = parser.parse_args()
    print(HEAD.format(least=arguments.least))
    for place in PLACES:
        folder = arguments.scenes / place.folder
        done = convert(PipelineOptions(folder / "area.osm", (folder / "dem.tif",)), Diagnostics())
        report = done.road_map.elevation_report
        print(f"\n## {place.title}\n\n{place.text}\n")
        for line in rows(report.structures if report else (), arguments.least):
            print(line)


if __name__ == "__main__":
    main()
