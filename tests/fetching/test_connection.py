"""How servers are asked, and what is made of their answers."""

from __future__ import annotations

import email.utils
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from web_server import PAGE, Reply, WebServer, web_server, write_certificate

from osm2xodr.errors import OptionError
from osm2xodr.fetching import Network, ServerError
from osm2xodr.fetching.connection import Connection, check_address, shown


@dataclass
class Patient:
    """What was said and waited."""

    said: list[str] = field(default_factory=list)
    waited: list[float] = field(default_factory=list)

    def network(self, **more: Any) -> Network:
        return Network(**{"note": self.said.append, "sleep": self.waited.append, **more})


@pytest.fixture
def server() -> Iterator[WebServer]:
    with web_server() as made:
        yield made


@pytest.fixture
def patient() -> Patient:
    return Patient()


def get(connection: Connection, url: str) -> bytes:
    return connection.ask(url, "--option", lambda response: b"".join(connection.chunks(response)))


def test_an_answer_is_read_to_its_end(server: WebServer, patient: Patient) -> None:
    content = bytes(range(256)) * 1000
    url = server.serve("/a", Reply(content))
    assert get(Connection(patient.network()), url) == content
    assert get(Connection(patient.network()), server.serve("/b", Reply(content, headers={"Content-Length": ""})))
    assert patient.said == []
    assert server.requests[0].headers["User-Agent"].startswith("osm2xodr/")


@pytest.mark.parametrize("status", [408, 429, 500, 502, 503, 504])
def test_a_busy_server_is_asked_again_when_it_says(server: WebServer, patient: Patient, status: int) -> None:
    url = server.serve("/a", Reply(PAGE, status, {"Retry-After": "7"}), Reply(PAGE, status), Reply(b"data"))
    assert get(Connection(patient.network(pause=5.0)), url) == b"data"
    # After what the server says, and where it says nothing after pauses that double.
    assert patient.waited == [7.0, 10.0]
    assert f"(status {status}); it is asked again in 7 s" in patient.said[0]


def test_a_time_of_day_to_ask_again(server: WebServer, patient: Patient) -> None:
    at = email.utils.formatdate(time.time() + 100.0, usegmt=True)
    past = email.utils.formatdate(time.time() - 100.0, usegmt=True)
    busy = [Reply(status=429, headers={"Retry-After": text}) for text in (at, past, "soon")]
    url = server.serve("/a", *busy, Reply(b"data"))
    assert get(Connection(patient.network(pause=5.0)), url) == b"data"
    assert patient.waited[0] == pytest.approx(100.0, abs=3.0)
    assert patient.waited[1:] == [0.0, 20.0]


def test_it_waits_in_real_time(server: WebServer) -> None:
    url = server.serve("/a", Reply(status=429, headers={"Retry-After": "1"}), Reply(b"data"))
    assert get(Connection(Network()), url) == b"data"
    first, second = server.requests
    assert 1.0 <= second.at - first.at < 3.0


def test_it_does_not_wait_for_ever(server: WebServer, patient: Patient) -> None:
    url = server.serve("/a", Reply(status=429, headers={"Retry-After": "3600"}))
    with pytest.raises(ServerError) as caught:
        get(Connection(patient.network()), url)
    assert str(caught.value) == (
        f"{url} has too many requests of this machine (status 429) and asks to wait 60 minutes; try again then, or "
        "give another address with --option"
    )
    assert (len(server.requests), patient.waited) == (1, [])


def test_it_gives_up_in_one_sentence(server: WebServer, patient: Patient) -> None:
    url = server.serve("/a", Reply(PAGE, 504))
    with pytest.raises(ServerError) as caught:
        get(Connection(patient.network(retries=2)), url)
    assert str(caught.value) == (
        f"{url} is too busy (status 504), also after 2 further tries; try again later, the same command goes on "
        "where it ended, or give another address with --option"
    )
    assert caught.value.status == 504
    assert (len(server.requests), patient.waited) == (3, [5.0, 10.0])


@pytest.mark.parametrize("status", [400, 401, 403, 404, 410, 501])
def test_other_errors_are_final_and_quoted(server: WebServer, patient: Patient, status: int) -> None:
    url = server.serve("/a", Reply(PAGE, status))
    with pytest.raises(ServerError) as caught:
        get(Connection(patient.network()), f"{url}?secret=1")
    assert str(caught.value) == (
        f"{url} answers with status {status}: Please log in to this network.; check the address, or give another one "
        "with --option"
    )
    assert (caught.value.status, len(server.requests)) == (status, 1)


@pytest.mark.parametrize("cut", [0, 100_000])
def test_a_connection_that_is_cut(server: WebServer, patient: Patient, cut: int) -> None:
    content = bytes(300_000)
    url = server.serve("/a", Reply(content, cut=cut), Reply(content))
    assert get(Connection(patient.network()), url) == content
    after = " after 100,000 of 300,000 bytes" if cut else ""
    assert f"cut the connection{after}; it is asked again in 5 s" in patient.said[0]


def test_a_server_that_falls_silent(server: WebServer, patient: Patient) -> None:
    url = server.serve("/a", Reply(b"data", wait=1.0), Reply(b"data"))
    assert get(Connection(patient.network(patience=0.2)), url) == b"data"
    assert "does not answer; it is asked again" in patient.said[0]
    url = server.serve("/b", Reply(bytes(20), step=10, pause=1.0), Reply(b"data"))
    assert get(Connection(patient.network(patience=0.2)), url) == b"data"
    assert "fell silent after 10 of 20 bytes" in patient.said[1]


def test_a_slow_trickle_ends(server: WebServer, patient: Patient) -> None:
    url = server.serve("/a", Reply(bytes(10_000), step=1, pause=0.02), Reply(b"data"))
    began = time.monotonic()
    assert get(Connection(patient.network(patience=0.3)), url) == b"data"
    assert time.monotonic() - began < 3.0
    assert "sends less than 1 kB/s" in patient.said[0]


def test_a_server_may_take_longer_before_it_answers(server: WebServer, patient: Patient) -> None:
    url = server.serve("/a", Reply(b"data", wait=0.6))
    connection = Connection(patient.network(patience=0.2))
    read = connection.ask(url, "--option", lambda response: b"".join(connection.chunks(response)), silence=5.0)
    assert (read, patient.said) == (b"data", [])


def test_redirects_are_followed(server: WebServer, patient: Patient) -> None:
    server.serve("/new", Reply(b"data"))
    for status in (301, 302, 303, 307, 308):
        url = server.serve("/old", Reply(status=status, headers={"Location": f"{server.url}/new"}))
        assert get(Connection(patient.network()), url) == b"data"


@pytest.mark.parametrize("target", ["file:///etc/passwd", "ftp://127.0.0.1/x", "data:text/plain,x"])
def test_redirects_lead_to_web_servers_alone(server: WebServer, patient: Patient, target: str) -> None:
    url = server.serve("/old", Reply(status=302, headers={"Location": target}))
    with pytest.raises(ServerError, match="which is not followed; give another address"):
        get(Connection(patient.network()), url)


def test_no_redirect_leads_to_an_open_connection(
    server: WebServer, patient: Patient, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    certificate = write_certificate(tmp_path / "certificate.pem")
    monkeypatch.setenv("SSL_CERT_FILE", str(certificate))
    with web_server(certificate) as secure:
        url = secure.serve("/old", Reply(status=302, headers={"Location": f"{server.url}/new"}))
        with pytest.raises(ServerError, match=f"leads to {server.url}/new, which is not followed"):
            get(Connection(patient.network()), url)
        url = secure.serve("/old", Reply(status=302, headers={"Location": "/new"}))
        secure.serve("/new", Reply(b"data"))
        assert get(Connection(patient.network()), url) == b"data"


@pytest.mark.parametrize(
    "target", ["http://[::1", "http://a..b/", "http://a:99999/", "http://a:x/", "http://\x1b[2J/"]
)
def test_redirects_to_what_is_no_address(server: WebServer, patient: Patient, target: str) -> None:
    url = server.serve("/old", Reply(status=302, headers={"Location": target}))
    with pytest.raises(ServerError, match="which is not followed; give another address") as caught:
        get(Connection(patient.network()), url)
    assert str(caught.value).isprintable()


def test_no_other_header_leads_on(server: WebServer, patient: Patient) -> None:
    url = server.serve("/old", Reply(status=302, headers={"URI": f"{server.url}/new"}))
    with pytest.raises(ServerError, match="answers with status 302"):
        get(Connection(patient.network()), url)
    assert len(server.requests) == 1


@pytest.mark.parametrize("text", ["\xb2", "1" * 5000, "-1", "1, 1", "\xff", "1e9"])
def test_numbers_in_headers_that_are_none(server: WebServer, patient: Patient, text: str) -> None:
    headers = {"Content-Length": text, "Connection": "close", "Retry-After": text}
    assert get(Connection(patient.network()), server.serve("/a", Reply(b"data", headers=headers))) == b"data"
    url = server.serve("/b", Reply(b"", 503, headers={"Retry-After": text}), Reply(b"data"))
    assert get(Connection(patient.network(pause=5.0)), url) == b"data"
    assert patient.waited == [5.0]


def test_headers_have_a_clock(patient: Patient) -> None:
    """From the first byte of an answer on, whatever time the server may take before it."""
    for begin in (b"", b"HTTP/1.1 200 OK\r\n", b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n"):
        with dripping(begin) as url:
            connection, began = Connection(patient.network(patience=0.3, retries=0)), time.monotonic()
            with pytest.raises(ServerError, match=r"does not answer|fell silent"):
                connection.ask(url, "--option", partial(whole, connection), silence=30.0)
            assert time.monotonic() - began < 3.0


def whole(connection: Connection, response: Any) -> bytes:
    return b"".join(connection.chunks(response))


@contextmanager
def dripping(begin: bytes) -> Iterator[str]:
    """Serve an answer that goes on with a digit every 0.05 s."""
    with socket.create_server(("127.0.0.1", 0)) as listening:

        def serve() -> None:
            made, _ = listening.accept()
            with made, suppress(OSError):
                made.sendall(begin)
                while True:
                    made.sendall(b"1")
                    time.sleep(0.05)

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{listening.getsockname()[1]}/"
        thread.join()


def test_redirects_in_a_circle_end(server: WebServer, patient: Patient) -> None:
    url = server.serve("/a", Reply(status=302, headers={"Location": "/a"}))
    with pytest.raises(ServerError, match="answers with status 302"):
        get(Connection(patient.network()), url)
    assert len(server.requests) < 20


def test_what_is_no_web_server(patient: Patient) -> None:
    with pytest.raises(ServerError, match=r"cannot be reached .*: this machine may be offline") as caught:
        get(Connection(patient.network()), "http://127.0.0.1:1/a")
    assert caught.value.unreached == "connection refused"
    with pytest.raises(ServerError, match="cannot be reached") as caught:
        get(Connection(patient.network()), "http://no-such-name.invalid/a")
    assert caught.value.unreached != ""
    assert patient.waited == []


def test_an_encrypted_connection_to_a_server_without(server: WebServer, patient: Patient) -> None:
    url = server.serve("/a", Reply(b"data")).replace("http", "https")
    with pytest.raises(ServerError, match=r"cannot be reached over an encrypted connection \(.*\); give another"):
        get(Connection(patient.network()), url)


def test_addresses_are_checked() -> None:
    check_address("url", "https://example.org:8080/a?b=%20")
    for wrong in ("example.org", "file:///x", "http://", "http://a b", "http://a/ü", "ftp://a/b"):
        with pytest.raises(OptionError, match=r"url .* is no address; give one that begins with https://"):
            check_address("url", wrong)


def test_messages_hold_no_secrets() -> None:
    assert shown("https://me:secret@example.org:8/a/b?key=secret#c") == "https://example.org:8/a/b"
