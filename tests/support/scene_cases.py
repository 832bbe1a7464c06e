"""Small networks for scenes: roads that cross at one level and above each other."""

from __future__ import annotations

from pathlib import Path

from xodr_text import LINE, cubics, document, geometry, lane, read_text, road, section

from osm2xodr.opendrive.tables import OpenDrive

WALK = '<height sOffset="0" inner="0.12" outer="0.12"/>'
# Half of each side: 3.5 m to drive on and a pavement of 2 m.
STREET = section(
    0.0,
    lane(2, (0, 2.0), kind="sidewalk", more=WALK) + lane(1, (0, 3.5)),
    lane(-1, (0, 3.5)) + lane(-2, (0, 2.0), kind="sidewalk", more=WALK),
)


def crossing(folder: Path, *, height: float = 0.0, more: str = "") -> OpenDrive:
    """Return two streets of 100 m that cross at 0, 0, the second at a height (m) and with `more` elements."""
    roads = [
        road("1", geometry(LINE, 100.0, x=-50.0), lanes=STREET),
        road(
            "2",
            geometry(LINE, 100.0, y=-50.0, hdg=1.5707963267948966),
            lanes=STREET,
            elevation=cubics("elevation", (0, height)),
            more=more,
        ),
    ]
    return read_text(folder, document(*roads))
