"""Places by their names: what a geocoder is asked, what is taken, and answers that are none."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from web_server import PAGE, Reply, WebServer, web_server

from osm2xodr.errors import InputError
from osm2xodr.fetching import FetchOptions, Network, Place, ServerError
from osm2xodr.fetching.connection import Connection
from osm2xodr.fetching.place import find_place

SEARCH = "/search"
ORDINO: dict[str, Any] = {
    "osm_type": "relation", "osm_id": 2804754, "category": "boundary", "type": "administrative",
    "display_name": "Ordino, Andorra", "boundingbox": ["42.5400000", "42.6559357", "1.4500000", "1.6050000"],
}  # fmt: skip
HAMLET = {
    **ORDINO,
    "osm_type": "node",
    "osm_id": 7,
    "category": "place",
    "type": "hamlet",
    "display_name": "Ordino, Italy",
}
HAMLET["boundingbox"] = [45.0, 45.1, 9.0, 9.1]


def answer(*places: dict[str, Any]) -> Reply:
    return Reply(json.dumps(places).encode(), headers={"Content-Type": "application/json"})


@pytest.fixture
def server() -> Iterator[WebServer]:
    with web_server() as made:
        yield made


def find(server: WebServer, folder: Path, name: str, said: list[str] | None = None, **more: Any) -> Place:
    note = (lambda _: None) if said is None else said.append
    network = Network(retries=1, sleep=lambda _: None, note=note)
    options = FetchOptions(folder, folder, geocoder=f"{server.url}{SEARCH}", network=network, **more)
    return find_place(Connection(network), name, options)


def test_the_first_one_is_taken_and_others_are_named(server: WebServer, tmp_path: Path) -> None:
    server.serve(SEARCH, answer(ORDINO, HAMLET))
    said: list[str] = []
    place = find(server, tmp_path, "Ordino", said)
    assert place.box == (1.45, 42.54, 1.605, 42.6559357)
    assert place.text.startswith("Ordino, Andorra (boundary administrative relation 2804754), found by 127.0.0.1:")
    assert said == [
        "'Ordino' is Ordino, Andorra (boundary administrative relation 2804754): --bbox 1.45,42.54,1.605,42.65594",
        "another place of that name is Ordino, Italy (place hamlet node 7): --bbox 9,45,9.1,45.1",
    ]


def test_one_polite_request_whose_answer_is_kept(server: WebServer, tmp_path: Path) -> None:
    server.serve(SEARCH, answer(ORDINO))
    for _ in range(3):
        find(server, tmp_path, "Ordino & Müller, Andorra")
    (request,) = server.requests
    assert request.query == {"q": "Ordino & Müller, Andorra", "format": "jsonv2", "limit": "10"}
    assert request.headers["User-Agent"].startswith("osm2xodr/")
    find(server, tmp_path, "Ordino & Müller, Andorra", age=0.0)
    find(server, tmp_path, "Ordino")
    assert len(server.requests) == 3


@pytest.mark.parametrize(
    ("reply", "message"),
    [
        (Reply(PAGE), r"gives a web page \(Please log in to this network.\) instead of a list of places in JSON"),
        (Reply(b'{"error": "no"}'), "gives something else .* instead of a list of places in JSON; check the address"),
        (Reply(b"[" * 100_000), "gives places without bounds; check the address, or give another one with --geo"),
        (Reply(b"[1, 2]"), "gives places without bounds"),
        (answer({"display_name": "x"}), "gives places without bounds"),
        (answer({**ORDINO, "boundingbox": ["42", "nan", "1", "2"]}), "gives places without bounds"),
        (answer({**ORDINO, "boundingbox": [42, 43, 2, 1]}), "gives places without bounds"),
        (Reply(b"[" + b" " * 1_100_000), "sends over 1.0 MB; give another --geocoder"),
        (Reply(b"", 429, {"Retry-After": "1"}), "has too many requests of this machine"),
        (Reply(b"", 302, {"Location": "file:///etc/passwd"}), "leads to file:///etc/passwd, which is not followed"),
    ],
)  # fmt: skip
def test_answers_that_are_none(server: WebServer, tmp_path: Path, reply: Reply, message: str) -> None:
    server.serve(SEARCH, reply)
    with pytest.raises(ServerError, match=message):
        find(server, tmp_path, "Ordino")
    # A bad answer is not kept.
    server.serve(SEARCH, answer(ORDINO))
    assert find(server, tmp_path, "Ordino").box[1] == 42.54


def test_offline_it_says_what_else_there_is(tmp_path: Path) -> None:
    with web_server() as gone:
        pass
    with pytest.raises(
        ServerError, match=r"cannot be reached \(connection refused\): .*, or the box of the place with --b"
    ):
        find(gone, tmp_path, "Ordino")


def test_words_of_the_server_are_quoted_in_one_line(server: WebServer, tmp_path: Path) -> None:
    server.serve(SEARCH, answer({**ORDINO, "display_name": "a\n\x1b[31m<b>c</b>" + "d" * 10_000}))
    said: list[str] = []
    place = find(server, tmp_path, "Ordino", said)
    assert all(sign.isprintable() for sign in place.text + said[0])
    assert len(said[0]) < 500


def test_a_place_that_is_not_known(server: WebServer, tmp_path: Path) -> None:
    server.serve(SEARCH, answer())
    with pytest.raises(
        InputError, match="knows no place 'Orrdino'; write it another way, or give its box with --bbox"
    ):
        find(server, tmp_path, "Orrdino")
