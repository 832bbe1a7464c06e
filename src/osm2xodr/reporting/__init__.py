"""What a conversion comes to: the road network with its figures, a summary for people, a report for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.reporting.conversion import Conversion as Conversion, Written as Written
    from osm2xodr.reporting.report import (
        REPORT_FORMAT as REPORT_FORMAT,
        Progress as Progress,
        details as details,
        summary as summary,
    )
    from osm2xodr.reporting.statistics import summarize as summarize

__getattr__ = lazy_exports(
    __name__,
    {
        "conversion": ("Conversion", "Written"),
        "report": ("Progress", "REPORT_FORMAT", "details", "summary"),
        "statistics": ("summarize",),
    },
)
