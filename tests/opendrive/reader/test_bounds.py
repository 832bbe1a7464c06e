"""Small files that claim more than any road has."""

from __future__ import annotations

from pathlib import Path

import pytest
from xodr_text import read_text

from osm2xodr.errors import InputError

_LANE = '<lane id="-{}" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane>'


def road(number: int, length: str = "100", shape: str = "<line/>", lanes: int = 1, more: str = "") -> str:
    plan = f'<geometry s="0" x="0" y="0" hdg="0" length="{length}">{shape}</geometry>'
    right = "".join(_LANE.format(k) for k in range(1, lanes + 1))
    section = f'<laneSection s="0"><center><lane id="0" type="none"/></center><right>{right}</right></laneSection>'
    content = f"<planView>{plan}</planView><lanes>{section}</lanes>{more}"
    return f'<road id="{number}" name="" length="{length}" junction="-1">{content}</road>'


@pytest.mark.parametrize(
    ("roads", "words"),
    [
        (road(7, "1e9"), r"road '7' \(line \d+\) is 1e\+09 m long"),
        (road(7, "1000", '<arc curvature="1e11"/>'), "turns by 1e"),
        (road(7, "1000", '<spiral curvStart="0" curvEnd="-9"/>'), "turns by 9000 rad"),
        (road(7, lanes=501), "<laneSection> of 502 lanes"),
        ("".join(map(road, range(201))), "<geometry> that 201 roads have"),
        (road(7).replace('c="0"', 'c="0.06"'), r"road '7' \(line \d+\) has a <lane> 603 m wide"),
        (road(7).replace('c="0"', 'c="-0.06"'), "<lane> 597 m wide"),
        (
            road(7).replace("<laneSection", '<laneOffset s="50" a="0" b="11" c="0" d="0"/><laneSection'),
            "<laneOffset> of 550 m",
        ),
        (road(7, more="<userData>" * 200 + "</userData>" * 200), "elements within each other in line"),
    ],
)
def test_what_no_road_has_is_refused(roads: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        read_text(tmp_path, f"<OpenDRIVE>{roads}</OpenDRIVE>")


def test_what_roads_may_have_is_read(tmp_path: Path) -> None:
    spiral = '<spiral curvStart="0" curvEnd="0.2"/>'
    wide = road(4).replace('a="3"', 'a="400"')
    roads = f"{road(1, '90000')}{road(2, '600', spiral)}{road(3, lanes=40)}{wide}"
    file = read_text(tmp_path, f"<OpenDRIVE>{roads}</OpenDRIVE>")
    assert len(file.roads.id) == 4
