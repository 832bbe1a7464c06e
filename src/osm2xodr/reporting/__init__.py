"""What a conversion comes to: the road network with its figures, a summary for people, a report for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.reporting.conversion import Conversion as Conversion, Written as Written
    from osm2xodr.reporting.report import (
        REPORT_FORMAT as REPORT_FORMAT,
        Code as Code,
        codes as codes,
        details as details,
    )
    from osm2xodr.reporting.statistics import summarize as summarize
    from osm2xodr.reporting.summary_lines import (
        Line as Line,
        Style as Style,
        kinds_of_findings as kinds_of_findings,
        summary as summary,
    )

__getattr__ = lazy_exports(
    __name__,
    {
        "report": ("REPORT_FORMAT", "Code", "codes", "details"),
        "conversion": ("Conversion", "Written"),
        "statistics": ("summarize",),
        "summary_lines": ("Line", "Style", "kinds_of_findings", "summary"),
    },
)
