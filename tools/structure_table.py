#!/usr/bin/env python3
"""Prints the bridges and tunnels of an area with their clearances and grades, as a Markdown table.

    python tools/structure_table.py AREA.osm DEM.tif [DEM.tif ...] [--least METRES]

The tables in docs/method/structures.md are made with it.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from osm2xodr.diagnostics import Diagnostics
from osm2xodr.geometry.heights import tolerated_grade
from osm2xodr.model import StructureRecord
from osm2xodr.pipeline import ConvertOptions, convert

HEAD = "| structure | OSM way | length, m | above the ground, m | clearance, m | largest grade | limit |"


def rows(structures: tuple[StructureRecord, ...], least: float) -> Iterator[str]:
    """Yield the lines of the table, for structures of a least length (m) and all that cross a road."""
    yield HEAD
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
    """Convert the area and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("area", type=Path)
    parser.add_argument("dem", type=Path, nargs="+")
    parser.add_argument("--least", type=float, default=20.0, help="leave out what is shorter and crosses no road, m")
    arguments = parser.parse_args()
    done = convert(ConvertOptions(arguments.area, tuple(arguments.dem)), Diagnostics())
    report = done.road_map.elevation_report
    for line in rows(report.structures if report else (), arguments.least):
        print(line)


if __name__ == "__main__":
    main()
