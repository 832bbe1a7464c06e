"""Small documents of OpenDRIVE as text, built from parts that tests replace."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from osm2xodr.opendrive.reader import read_xodr
from osm2xodr.opendrive.tables import OpenDrive

LINE = "<line/>"
PROJECTION = "+proj=tmerc +lat_0=50 +lon_0=11 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"
HEADER = f'<header revMajor="1" revMinor="7"><geoReference><![CDATA[{PROJECTION}]]></geoReference></header>'


def geometry(shape: str, length: float, s: float = 0.0, x: float = 0.0, y: float = 0.0, hdg: float = 0.0) -> str:
    return f'<geometry s="{s!r}" x="{x!r}" y="{y!r}" hdg="{hdg!r}" length="{length!r}">{shape}</geometry>'


def cubics(element: str, *records: Sequence[float], s_name: str = "s") -> str:
    """Return records of s, a and as many of b, c, d as are given."""
    filled = [(*record, 0.0, 0.0, 0.0)[:5] for record in records]
    return "".join(
        f'<{element} {s_name}="{s!r}" a="{a!r}" b="{b!r}" c="{c!r}" d="{d!r}"/>' for s, a, b, c, d in filled
    )


def lane(number: int, *widths: Sequence[float], kind: str = "driving", more: str = "", border: bool = False) -> str:
    records = cubics("border" if border else "width", *widths, s_name="sOffset")
    return f'<lane id="{number}" type="{kind}" level="false">{records}{more}</lane>'


def section(s: float, left: str = "", right: str = "", centre: str = '<lane id="0" type="none"/>') -> str:
    sides = (("left", left), ("center", centre), ("right", right))
    return (
        f'<laneSection s="{s!r}">'
        + "".join(f"<{side}>{text}</{side}>" for side, text in sides if text)
        + ("</laneSection>")
    )


TWO_LANES = section(0.0, lane(1, (0, 3.5)), lane(-1, (0, 3.5)))


def road(
    number: str = "1",
    plan: str | None = None,
    length: float = 100.0,
    *,
    lanes: str = TWO_LANES,
    link: str = "",
    junction: str = "-1",
    elevation: str = "",
    lateral: str = "",
    more: str = "",
) -> str:
    plan = geometry(LINE, length) if plan is None else plan
    return (
        f'<road id="{number}" name="" length="{length!r}" junction="{junction}">\n<link>{link}</link>'
        f"<planView>{plan}</planView><elevationProfile>{elevation}</elevationProfile>"
        f"<lateralProfile>{lateral}</lateralProfile>\n<lanes>{lanes}</lanes>{more}</road>"
    )


def document(*parts: str, header: str = HEADER) -> str:
    return '<?xml version="1.0" encoding="UTF-8"?>\n<OpenDRIVE>\n' + "\n".join([header, *parts]) + "\n</OpenDRIVE>\n"


def read_text(folder: Path, text: str) -> OpenDrive:
    """Write a document and read it with the product."""
    path = folder / "map.xodr"
    path.write_text(text, encoding="utf-8")
    return read_xodr(path)
