"""To see a road network: `write_report` makes a page to explore it, `write_picture` a picture of it.

What is listed here is loaded when it is used: the command line reads the options first, and most of the rest is slow
to import.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from osm2xodr.system import lazy_exports

if TYPE_CHECKING:
    from osm2xodr.viewing.options import (
        PICTURE_COLOURS as PICTURE_COLOURS,
        PictureOptions as PictureOptions,
        ReportOptions as ReportOptions,
    )
    from osm2xodr.viewing.page import write_report as write_report
    from osm2xodr.viewing.picture import (
        box_of_degrees as box_of_degrees,
        draw_thumbnail as draw_thumbnail,
        write_picture as write_picture,
    )
    from osm2xodr.viewing.shell import (
        facts as facts,
        filled as filled,
        package_text as package_text,
        page_html as page_html,
    )
    from osm2xodr.viewing.surface_report import surface_page as surface_page

__getattr__ = lazy_exports(
    __name__,
    {
        "options": ("PICTURE_COLOURS", "PictureOptions", "ReportOptions"),
        "page": ("write_report",),
        "picture": ("box_of_degrees", "draw_thumbnail", "write_picture"),
        "shell": ("facts", "filled", "package_text", "page_html"),
        "surface_report": ("surface_page",),
    },
)
