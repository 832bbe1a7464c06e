"""Stage 5: write a `RoadMap` as an ASAM OpenDRIVE file. Nothing is computed here except text and bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import ByteSink
from osm2xodr.xodrWriter.options import VERSIONS as VERSIONS, WriteOptions as WriteOptions, check_date as check_date

if TYPE_CHECKING:
    from osm2xodr.diagnostics import Diagnostics
    from osm2xodr.model import PlanView, RoadMap


def write_xodr(
    road_map: RoadMap, stream: ByteSink, options: WriteOptions, diagnostics: Diagnostics, jobs: int = 1
) -> None:
    """Write a road network as OpenDRIVE to a binary stream.

    The same road map and options give the same bytes. Text is made and written in blocks of roads, so that the
    document never stands in memory as a whole.

    Parameters
    ----------
    road_map
        What to write.
    stream
        Receives the document, UTF-8.
    options
        Version of OpenDRIVE, and the texts of the header.
    diagnostics
        Receives what the chosen version cannot express.
    jobs
        How many processes make text, at least 1; the bytes do not depend on it.

    Raises
    ------
    OutputError
        If the road map cannot be written: values that are not finite, roads without length, ids used twice. The
        geometry stage never makes such a map.
    OSError
        From the stream.
    """
    # Here, so that the command line starts without numpy.
    from osm2xodr.xodrWriter.document import write_document

    write_document(road_map, stream, options, diagnostics, jobs)


def signal_programmes(road_map: RoadMap, options: WriteOptions) -> bytes:
    """Return the signal programmes of a road network as a file for SUMO's netconvert; empty if it has none.

    They go with what `write_xodr` writes with the same options.
    """
    from osm2xodr.xodrWriter.document import words_for
    from osm2xodr.xodrWriter.furniture_text import programmes_text

    return programmes_text(road_map, words_for(road_map, options)).encode()


def plan_view_bounds(plan: PlanView) -> tuple[float, float, float, float]:
    """Return west, south, east, north of all reference lines (at least one record), m, as headers state them."""
    from osm2xodr.xodrWriter.document import plan_view_bounds as bounds

    return bounds(plan)
