"""Files that are downloaded once, in as many pieces as it takes."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections import namedtuple
from collections.abc import Iterator
from pathlib import Path

import pytest
from web_server import PAGE, Reply, WebServer, part_of, web_server

from osm2xodr.errors import OutputError
from osm2xodr.fetching import Network, ServerError
from osm2xodr.fetching.connection import Connection
from osm2xodr.fetching.downloads import Wanted, download

CONTENT = b"DATA" + bytes(range(256)) * 2000
DAY = 86_400.0


@pytest.fixture
def server() -> Iterator[WebServer]:
    with web_server() as made:
        yield made


def wanted(url: str) -> Wanted:
    return Wanted(url, "--extract", "OSM data", lambda head: head.startswith(b"DATA"))


def connection(**more: object) -> Connection:
    return Connection(Network(**{"retries": 0, "sleep": lambda _: None, **more}))  # type: ignore[arg-type]


def test_a_file_is_downloaded_once(server: WebServer, tmp_path: Path) -> None:
    url = server.serve_file("/map.osm.pbf", CONTENT)
    for _ in range(2):
        found = download(connection(), wanted(url), tmp_path / "cache", DAY)
        assert found.read_bytes() == CONTENT
        assert found.name.endswith("-map.osm.pbf")
    assert len(server.requests) == 1
    assert list((tmp_path / "cache").iterdir()) == [found]


def test_old_files_are_fetched_anew(server: WebServer, tmp_path: Path) -> None:
    url = server.serve_file("/map", CONTENT)
    found = download(connection(), wanted(url), tmp_path, DAY)
    os.utime(found, (time.time() - 2 * DAY,) * 2)
    server.serve_file("/map", CONTENT + b"new")
    assert download(connection(), wanted(url), tmp_path, 3 * DAY).read_bytes() == CONTENT
    assert download(connection(), wanted(url), tmp_path, DAY).read_bytes() == CONTENT + b"new"


def test_files_of_the_same_name_are_kept_apart(server: WebServer, tmp_path: Path) -> None:
    one = server.serve_file("/a/map", CONTENT)
    other = server.serve_file("/b/map", CONTENT + b"other")
    assert download(connection(), wanted(one), tmp_path, DAY).read_bytes() == CONTENT
    assert download(connection(), wanted(other), tmp_path, DAY).read_bytes() == CONTENT + b"other"


def test_names_stay_in_the_folder(server: WebServer, tmp_path: Path) -> None:
    for path in ("/..%2F..%2Fevil", "/a/.hidden", "/", "/" + "x" * 3000):
        server.serve_file(path.replace("%2F", "/"), CONTENT)
        found = download(connection(), wanted(server.url + path), tmp_path / "cache", DAY)
        assert found.parent == tmp_path / "cache"
        assert not found.name.startswith(".")
    assert [path.name for path in tmp_path.iterdir()] == ["cache"]


def test_it_goes_on_where_the_connection_was_cut(server: WebServer, tmp_path: Path) -> None:
    cut = [lambda request: part_of(CONTENT, request, cut=100_000)] * 3
    url = server.serve_file("/map", CONTENT, *cut)
    found = download(connection(retries=3), wanted(url), tmp_path, DAY)
    assert found.read_bytes() == CONTENT
    asked = [request.headers.get("Range") for request in server.requests]
    assert asked == [None, "bytes=100000-", "bytes=200000-", "bytes=300000-"]


def test_it_goes_on_when_it_is_started_again(server: WebServer, tmp_path: Path) -> None:
    url = server.serve_file("/map", CONTENT, lambda request: part_of(CONTENT, request, cut=100_000))
    with pytest.raises(ServerError, match="cut the connection after 100,000 of 512,004 bytes"):
        download(connection(), wanted(url), tmp_path, DAY)
    # Nothing looks whole.
    assert sorted(path.name.split(".part")[1] for path in tmp_path.iterdir()) == ["", ".json"]
    found = download(connection(), wanted(url), tmp_path, DAY)
    assert found.read_bytes() == CONTENT
    assert server.requests[1].headers["Range"] == "bytes=100000-"
    assert list(tmp_path.iterdir()) == [found]


def test_a_file_that_has_changed_meanwhile_is_fetched_whole(server: WebServer, tmp_path: Path) -> None:
    url = server.serve_file("/map", CONTENT, lambda request: part_of(CONTENT, request, cut=100_000))
    with pytest.raises(ServerError):
        download(connection(), wanted(url), tmp_path, DAY)
    changed = CONTENT[:4] + CONTENT[4:][::-1]
    server.serve_file("/map", changed)
    assert download(connection(), wanted(url), tmp_path, DAY).read_bytes() == changed


def test_a_file_that_has_become_shorter(server: WebServer, tmp_path: Path) -> None:
    """The server says that there is no such part (416), whatever else it knows."""
    url = server.serve_file("/map", CONTENT, lambda request: part_of(CONTENT, request, cut=100_000))
    with pytest.raises(ServerError):
        download(connection(), wanted(url), tmp_path, DAY)
    server.serve("/map", Reply(status=416), Reply(b"DATA short"))
    assert download(connection(), wanted(url), tmp_path, DAY).read_bytes() == b"DATA short"


@pytest.mark.parametrize("ranges", ["bytes 0-99/512004", "nonsense"])
def test_a_server_that_sends_another_part(server: WebServer, tmp_path: Path, ranges: str) -> None:
    wrong = Reply(CONTENT[:100], 206, {"Content-Range": ranges})
    url = server.serve("/map", lambda request: part_of(CONTENT, request, cut=100_000), wrong, Reply(CONTENT))
    found = download(connection(retries=3), wanted(url), tmp_path, DAY)
    assert found.read_bytes() == CONTENT


def test_a_server_without_parts_sends_everything_again(server: WebServer, tmp_path: Path) -> None:
    url = server.serve("/map", Reply(CONTENT, cut=100_000), Reply(CONTENT))
    assert download(connection(retries=1), wanted(url), tmp_path, DAY).read_bytes() == CONTENT


def test_through_redirects(server: WebServer, tmp_path: Path) -> None:
    cut = lambda request: part_of(CONTENT, request, cut=100_000)  # noqa: E731
    server.serve_file("/map-261120.osm.pbf", CONTENT, cut)
    url = server.serve("/map-latest.osm.pbf", Reply(status=302, headers={"Location": "/map-261120.osm.pbf"}))
    assert download(connection(retries=1), wanted(url), tmp_path, DAY).read_bytes() == CONTENT
    assert [request.headers.get("Range") for request in server.requests][2:] == ["bytes=100000-"] * 2


@pytest.mark.parametrize(
    ("reply", "found"),
    [
        (Reply(PAGE, headers={"Content-Type": "text/html"}), "a web page (Please log in to this network.)"),
        (Reply(PAGE + bytes(10_000)), "a web page (Please log in to this network.)"),
        (Reply(b'{"error": 1}', headers={"Content-Type": "application/json"}), "something else (application/json)"),
        (Reply(bytes(100_000), headers={"Content-Type": "image/png"}), "something else (image/png)"),
        (Reply(b""), "nothing"),
    ],
)
def test_what_is_not_wanted_leaves_nothing_behind(
    server: WebServer, tmp_path: Path, reply: Reply, found: str
) -> None:
    url = server.serve("/map", reply)
    with pytest.raises(ServerError) as caught:
        download(connection(), wanted(url), tmp_path, DAY)
    assert str(caught.value) == (
        f"{url} gives {found} instead of OSM data; check the address, or give another one with --extract"
    )
    assert [path.name for path in tmp_path.iterdir() if not path.name.endswith(".json")] == []


@pytest.mark.parametrize("stated", [True, False])
def test_too_large_a_file(server: WebServer, tmp_path: Path, stated: bool) -> None:
    url = server.serve("/map", Reply(CONTENT, headers={} if stated else {"Content-Length": ""}))
    with pytest.raises(ServerError, match=r"MB or more, but --max-download allows 0.2 MB; allow more, or give"):
        download(connection(download_max=200_000), wanted(url), tmp_path, DAY)
    assert not any(path.stat().st_size > 1000 for path in tmp_path.iterdir())


def test_too_little_room(server: WebServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usage = namedtuple("usage", "free")
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(100_000))
    url = server.serve_file("/map", CONTENT)
    with pytest.raises(OutputError, match=r"needs 1 MB, but .* has only 0 MB left; free some space, or choose"):
        download(connection(), wanted(url), tmp_path, DAY)


def test_a_disk_that_is_full(server: WebServer, tmp_path: Path) -> None:
    """The kernel refuses to let the file grow, in a process of its own; with more room it goes on."""
    url = server.serve_file("/map", CONTENT)
    script = (
        "import resource, signal, sys, pathlib\n"
        "from osm2xodr.fetching import Network\n"
        "from osm2xodr.fetching.connection import Connection\n"
        "from osm2xodr.fetching.downloads import Wanted, download\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))\n"
        "try:\n"
        "    download(Connection(Network()), Wanted(sys.argv[1], '-', '-', bool), pathlib.Path(sys.argv[2]), 1.0)\n"
        "except Exception as error:\n"
        "    print(type(error).__name__, error)\n"
    )
    run = subprocess.run([sys.executable, "-c", script, url, tmp_path], capture_output=True, text=True, check=True)
    assert run.stdout.startswith("OutputError cannot write ")
    assert "file too large; the file is larger than allowed there, choose another place" in run.stdout
    found = download(connection(), wanted(url), tmp_path, DAY)
    assert found.read_bytes() == CONTENT
    first = int(server.requests[-1].headers["Range"].removeprefix("bytes=").rstrip("-"))
    assert 100_000 < first <= 200_000
