"""Maps from servers of the Overpass API: queries, sizes, parts, and answers that are none.

Queries for buildings and water, carried out on a map in memory.
"""

from __future__ import annotations

import gzip
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from map_service import ORDINO, OSM_BASE, Overpass, answer
from overpass_ql import MapData
from riverside import BOX, RIVERSIDE, ROADS_ALONE, WITH_SURROUNDINGS
from web_server import PAGE, Reply, Request, WebServer, web_server

from osm2xodr.errors import InputError
from osm2xodr.fetching import FetchOptions, Network, ServerError, overpass
from osm2xodr.fetching.connection import Connection
from osm2xodr.fetching.overpass import area_query, count_query, data_date, fetch_parts, servers_of
from osm2xodr.fetching.place import Box
from osm2xodr.osmParsing import SURROUNDINGS_KEYS, SURROUNDINGS_TAGS, in_surroundings, is_thing

API = "/api/interpreter"
COUNT = Reply(answer('<count id="0"><tag k="total" v="5"/></count>'))


@pytest.fixture
def server() -> Iterator[WebServer]:
    with web_server() as made:
        yield made


def fetch(server: WebServer, folder: Path, *urls: str, said: list[str] | None = None, **more: Any) -> list[Path]:
    note = (lambda _: None) if said is None else said.append
    network = Network(**{"retries": 0, "sleep": lambda _: None, "note": note, **more})
    options = FetchOptions(folder, folder, overpass=urls or (server.url + API,), network=network)
    return fetch_parts(Connection(network), ORDINO, options)


def test_the_query_is_for_what_conversions_read() -> None:
    query = area_query((1.5, 42.5, 1.6, 42.25), surroundings=False)
    assert query.startswith("[out:xml][timeout:180][maxsize:536870912];(")
    assert 'way["highway"](42.5,1.5,42.25,1.6);' in query
    assert 'way["barrier"~"^(bollard|fence|guard_rail|' in query
    assert 'node["natural"="tree"](42.5,1.5,42.25,1.6);' in query
    assert '(rel(bw.ways)["type"~"^(connectivity|restriction|' in query
    assert query.endswith("(.ways;.corners;.things;.rules;.named;.ends;);out meta;")
    # Each node that stands for something is among them.
    things = [{"highway": "stop"}, {"traffic_sign": "DE:274"}, {"barrier": "bollard"}, {"natural": "tree"}]
    things += [{"highway": "street_lamp"}, {"public_transport": "platform", "bus": "yes"}]
    for tags in things:
        assert is_thing(tags, frozenset({"lamps", "trees"}))
        key, value = next(iter(tags.items()))
        assert any(f'node["{key}"{text}](' in query for text in ("", f'="{value}"'))
    assert count_query((1.5, 42.5, 1.6, 42.25), surroundings=False).endswith(");out count;")
    # No server takes addresses of more than some 8 kB.
    assert len(query) < 4000


def test_the_size_is_asked_for_first(server: WebServer, tmp_path: Path) -> None:
    made = Overpass()
    server.serve(API, made)
    (part,) = fetch(server, tmp_path)
    assert (made.counted, made.boxes) == ([ORDINO], [ORDINO])
    assert data_date(part) == OSM_BASE
    assert [request.headers["Accept-Encoding"] for request in server.requests] == ["gzip", "gzip"]


def test_large_areas_are_split(server: WebServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = Overpass()
    server.serve(API, made)
    monkeypatch.setattr(overpass, "_PART_MAX", 20)
    parts = fetch(server, tmp_path)
    assert len(parts) == len(made.boxes) > 4
    assert made.counted[0] == ORDINO
    # The parts fill the area, none twice.
    area = sum((box[2] - box[0]) * (box[3] - box[1]) for box in made.boxes)
    assert area == pytest.approx((ORDINO[2] - ORDINO[0]) * (ORDINO[3] - ORDINO[1]), rel=1e-3)
    for box in made.boxes:
        (total,) = re.findall(r' v="(\d+)"', made.data.run(count_query(box, surroundings=True)))
        assert int(total) <= 20


@pytest.mark.parametrize(
    "words",
    [
        'runtime error: Query timed out in "query" at line 3 after 180 seconds.',
        "runtime error: Query run out of memory using about 2048 MB of RAM.",
    ],
)
def test_parts_that_are_too_much_for_the_server_are_split(server: WebServer, tmp_path: Path, words: str) -> None:
    """The server has begun to answer when it finds that out: what is there then is not all."""
    made = Overpass()

    def limited(request: Request) -> Reply:
        done = made(request)
        if len(made.boxes) == 1 and b"<count" not in done.body:
            return Reply(done.body.replace(b"</osm>", f"<remark> {words} </remark></osm>".encode()))
        return done

    server.serve(API, limited)
    assert len(fetch(server, tmp_path)) == 4
    assert len(made.boxes) == 5


def test_other_remarks_are_errors(server: WebServer, tmp_path: Path) -> None:
    remark = answer("<remark> runtime error: open64: 2 No such file or directory </remark>")
    server.serve(API, COUNT, Reply(remark))
    with pytest.raises(ServerError, match=r"could not answer \(runtime error: open64: 2 No such file or directory\)"):
        fetch(server, tmp_path)
    assert len(list((tmp_path / "overpass").glob("*.osm"))) == 1


def test_it_goes_on_with_the_part_that_is_missing(
    server: WebServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = Overpass()
    monkeypatch.setattr(overpass, "_PART_MAX", 40)

    def ends(request: Request) -> Reply:
        return Reply(PAGE, 504) if len(made.boxes) == 3 else made(request)

    server.serve(API, ends)
    with pytest.raises(ServerError, match=r"is too busy \(status 504\)"):
        fetch(server, tmp_path)
    server.serve(API, made)
    parts = fetch(server, tmp_path)
    assert len(parts) == len(made.boxes) == len(set(made.boxes))
    assert len(made.counted) == len(set(made.counted))


def test_compressed_answers(server: WebServer, tmp_path: Path) -> None:
    made = Overpass()
    packed = {"Content-Encoding": "gzip"}
    query = area_query(ORDINO, surroundings=True)
    whole = gzip.compress(made(Request("GET", API, {"data": query}, {}, 0.0)).body)
    damaged = whole[:1000] + bytes(100) + whole[1100:]
    count = Reply(gzip.compress(COUNT.body), headers=packed)
    server.serve(API, count, *(Reply(body, headers=packed) for body in (damaged, whole[:-20], whole)))
    said: list[str] = []
    (part,) = fetch(server, tmp_path, said=said, retries=2)
    assert part.read_bytes() == gzip.decompress(whole)
    assert "sends a damaged answer" in said[0]
    assert "cut its answer short" in said[1]


def test_an_answer_that_ends_too_early(server: WebServer, tmp_path: Path) -> None:
    """Without a length nothing but the content shows that."""
    whole = answer("<node id='1' lat='1' lon='1'/>")
    short = Reply(whole[:-10], headers={"Content-Length": ""})
    server.serve(API, COUNT, short, Reply(whole))
    said: list[str] = []
    fetch(server, tmp_path, said=said, retries=1)
    assert "cut its answer short; it is asked again" in said[0]


@pytest.mark.parametrize(
    ("reply", "message"),
    [
        (
            Reply(PAGE),
            r"gives a web page \(Please log in to this network.\) instead of OSM data in XML; check the addr",
        ),
        (Reply(b'{"version": 0.6}'), r"gives something else \(.*0.6.*\) instead of OSM data in XML"),
        (Reply(b""), r"gives something else \(empty\) instead"),
        (Reply(PAGE, 400), "answers with status 400: Please log in to this network"),
        (Reply(answer("")), "is of no use: its answer does not say how much there is in the area; try again later"),
    ],
)
def test_answers_that_are_none(server: WebServer, tmp_path: Path, reply: Reply, message: str) -> None:
    server.serve(API, reply)
    with pytest.raises(ServerError, match=message):
        fetch(server, tmp_path)
    assert list((tmp_path / "overpass").glob("*.osm")) == []


def test_entities_are_refused(server: WebServer, tmp_path: Path) -> None:
    bomb = b'<?xml version="1.0"?><!DOCTYPE osm [<!ENTITY a "aaaa">]>' + COUNT.body.partition(b"?>")[2]
    server.serve(API, Reply(bomb))
    with pytest.raises(ServerError, match="is of no use: its answer is XML with a document type declaration"):
        fetch(server, tmp_path)


BAD = (
    b"<osm version='0.6'><node id='1' lat='x' lon='1'/></osm>",
    b"<osm version='0.6'><node id='1' lat='1'</osm>",
    b"<osm version='0.6'><way id='1'><nd ref='1'></osm>",
    b'<?xml version="1.0"?><!DOCTYPE osm [<!ENTITY a "b">]><osm version="0.6"><node id="1" lat="1" lon="1"/></osm>',
)


@pytest.mark.parametrize("bad", BAD)
def test_answers_are_looked_at_before_they_are_kept(server: WebServer, tmp_path: Path, bad: bytes) -> None:
    """A bad one blocks neither the server, when it is well again, nor another one."""
    made = Overpass()
    url = server.serve(API, COUNT, Reply(bad))
    with pytest.raises(ServerError, match="is of no use: its answer"):
        fetch(server, tmp_path)
    # The count is kept.
    assert len(list((tmp_path / "overpass").glob("*.osm"))) == 1
    server.serve(API, made)
    (part,) = fetch(server, tmp_path)
    assert b"<way" in part.read_bytes()
    other = server.serve("/other", Reply(answer("")))
    server.serve(API, COUNT, Reply(bad))
    with pytest.raises(ServerError, match="does not say how much"):
        fetch(server, tmp_path, other)
    # What is kept and was damaged since is asked for anew; and the next server is asked where one is of no use.
    part.write_bytes(bad)
    server.serve("/other", made)
    said: list[str] = []
    fetch(server, tmp_path, url, other, said=said)
    assert "is of no use: its answer" in said[0]


def test_counts_that_split_for_ever_end(server: WebServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overpass, "_PARTS_MAX", 20)
    server.serve(API, Reply(COUNT.body.replace(b'"5"', b'"70000"')))
    with pytest.raises(ServerError, match="split the area over 20 times; give others"):
        fetch(server, tmp_path)
    assert len(server.requests) < 20


def test_the_next_server_is_asked_where_one_fails(server: WebServer, tmp_path: Path) -> None:
    made = Overpass()
    bad, good = server.serve("/bad", Reply(PAGE, 504)), server.serve("/good", made)
    said: list[str] = []
    with web_server() as gone:
        pass
    parts = fetch(server, tmp_path, gone.url, bad, good, said=said)
    assert len(said) == 2
    assert "cannot be reached (connection refused); 127.0.0.1" in said[0]
    assert f"is of no use ({bad} is too busy (status 504), also after 0 further tries; " in said[1]
    # What has failed is not asked again.
    assert [request.path for request in server.requests] == ["/bad", "/good", "/good"]
    assert servers_of(parts) == [good]
    with pytest.raises(ServerError, match="is too busy"):
        fetch(server, tmp_path / "anew", gone.url, bad)


def test_areas_that_are_too_large_are_refused(server: WebServer, tmp_path: Path) -> None:
    options = FetchOptions(tmp_path, tmp_path, overpass=(server.url + API,))
    with pytest.raises(InputError, match="the area has 20 square degrees, too much for the Overpass API; give a map"):
        fetch_parts(Connection(Network()), (5.0, 45.0, 10.0, 49.0), options)
    assert server.requests == []
    server.serve(API, Reply(COUNT.body.replace(b'"5"', b'"2000000"')))
    text = "the area has 2,000,000 ways and objects, too many for the Overpass API; "
    with pytest.raises(
        InputError, match=f"^{text}leave out buildings and water with --no-surroundings, or give a map"
    ):
        fetch(server, tmp_path)
    with pytest.raises(InputError, match=f"^{text}give a map with --extract"):
        fetch_parts(Connection(Network()), ORDINO, replace(options, surroundings=False))
    assert len(server.requests) == 2


def test_a_server_that_never_can(server: WebServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overpass, "_SPLITS_MAX", 2)
    server.serve(API, Reply(answer("<remark>runtime error: Query timed out</remark>")))
    with pytest.raises(ServerError, match=r"cannot give even a small part of it \(.*\); give others"):
        fetch(server, tmp_path)


def test_a_query_may_be_part_of_an_address_that_has_one(server: WebServer, tmp_path: Path) -> None:
    made = Overpass()
    server.serve("/api", made)
    fetch(server, tmp_path, f"{server.url}/api?key=mine")
    assert {request.query["key"] for request in server.requests} == {"mine"}


@pytest.fixture
def data(tmp_path: Path) -> MapData:
    return MapData(RIVERSIDE.write(tmp_path))


def numbers(text: str, kind: str) -> list[int]:
    """Return the ids of a kind in an answer, in their order; each is there once."""
    found = [int(number) for number in re.findall(rf'<{kind} id="(\d+)"', text)]
    assert len(found) == len(set(found))
    return sorted(found)


def test_roads_alone(data: MapData) -> None:
    text = data.run(area_query(BOX, surroundings=False))
    assert tuple(numbers(text, kind) for kind in ("node", "way", "relation")) == ROADS_ALONE


def test_buildings_and_water_come_as_far_as_is_reasonable(data: MapData) -> None:
    text = data.run(area_query(BOX, surroundings=True))
    assert tuple(numbers(text, kind) for kind in ("node", "way", "relation")) == WITH_SURROUNDINGS


def test_what_only_outlines_need_has_no_tags(data: MapData) -> None:
    text = data.run(area_query(BOX, surroundings=True))
    assert "traffic_sign" not in text
    # Of the two walls the one in the area.
    assert text.count('v="wall"') == 1
    assert re.search(r'<way id="41"( version="1")?><nd ref="44" ?/><nd ref="43" ?/></way>', text)
    # What is tagged as a part of a road stays.
    assert 'v="turning_circle"' in text


def test_the_count_is_of_what_comes(data: MapData) -> None:
    # Nodes that mean something by themselves are counted, those of ways are not.
    assert data.run(count_query(BOX, surroundings=False)) == '<count id="0"><tag k="total" v="3"/></count>'
    _, ways, relations = WITH_SURROUNDINGS
    total = len(ways) + len(relations)
    assert data.run(count_query(BOX, surroundings=True)) == f'<count id="0"><tag k="total" v="{total}"/></count>'


def test_all_that_scenes_read_is_asked_for() -> None:
    query = area_query(BOX, surroundings=True)
    for key in SURROUNDINGS_KEYS:
        assert in_surroundings({key: "yes"})
        assert f'rel["type"="multipolygon"]["{key}"](' in query
        assert f'way["{key}"](' in query
    for key, value in SURROUNDINGS_TAGS:
        assert in_surroundings({key: value})
        assert not in_surroundings({key: "other"})
        assert re.search(rf'way\["{key}"~"\^\((\w+\|)*{value}(\|\w+)*\)\$"\]', query)
    assert len(query) < 4000


@pytest.mark.parametrize(
    ("box", "near"),
    [
        ((7.0, 0.0, 7.1, 0.1), "way(r.areas)(-0.0089932,6.9910068,0.1089932,7.1089932);"),
        ((-179.999, 60.0, 0.0, 89.999), "way(r.areas)(59.9910068,-180,90,"),
        ((7.0, -60.1, 7.1, -60.0), "way(r.areas)(-60.1089932,6.981"),
    ],
)
def test_outlines_are_asked_for_a_kilometre_around(box: Box, near: str) -> None:
    assert near in area_query(box, surroundings=True)
    assert near in count_query(box, surroundings=True)
