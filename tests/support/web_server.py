"""A web server on this machine that does what it is told, good and bad."""

from __future__ import annotations

import datetime
import ipaddress
import re
import ssl
import threading
import time
import urllib.parse
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

# How long the server works on a request, s.
_WORK = 0.005
PAGE = (
    b"<!DOCTYPE html><html><head><title>x</title></head><body><h1>Please log in</h1> to this network.</body></html>"
)


@dataclass
class Request:
    """A request that was made."""

    method: str
    path: str  # Without the query
    query: dict[str, str]
    headers: Mapping[str, str]
    at: float  # When, s


@dataclass
class Reply:
    """An answer."""

    body: bytes = b""
    status: int = 200
    headers: dict[str, str] = field(default_factory=dict)
    cut: int | None = None  # After how many bytes the connection ends
    step: int = 1 << 16  # How many bytes are sent at a time
    pause: float = 0.0  # How long it waits between them, s
    wait: float = 0.0  # How long it is silent before it answers, s


Answer = Reply | Callable[[Request], Reply]


class WebServer:
    """What the server has: an answer for each path, or several one after the other of which the last one stays."""

    def __init__(self) -> None:
        self.answers: dict[str, list[Answer]] = {}
        self.requests: list[Request] = []
        self.url = ""
        self.busy = self.most_at_once = 0
        self.lock = threading.Lock()

    def serve(self, path: str, *answers: Answer) -> str:
        """Set what is at a path, and return its address."""
        self.answers[path] = list(answers)
        return self.url + path

    def serve_file(self, path: str, content: bytes, *before: Answer, ranges: bool = True) -> str:
        """Set a file at a path, of which parts can be had; `before` are what is answered first."""
        return self.serve(path, *before, lambda request: part_of(content, request) if ranges else Reply(content))

    def asked(self, path: str) -> list[Request]:
        """Return the requests for a path."""
        return [request for request in self.requests if request.path == path]

    def answer(self, request: Request) -> Reply:
        """Return the next answer to a request."""
        found = self.answers.get(request.path)
        if not found:
            return Reply(b"<html><body>No such file.</body></html>", 404, {"Content-Type": "text/html"})
        item = found.pop(0) if len(found) > 1 else found[0]
        return item if isinstance(item, Reply) else item(request)


def part_of(content: bytes, request: Request, **more: Any) -> Reply:
    """Answer with a part of a file if it is asked for."""
    tag = f'"{hash(content):x}"'
    headers = {"ETag": tag, "Accept-Ranges": "bytes", "Content-Type": "application/octet-stream"}
    found = re.fullmatch(r"bytes=(\d+)-(\d*)", request.headers.get("Range", ""))
    if found is None or request.headers.get("If-Range", tag) != tag:
        return Reply(content, headers=headers, **more)
    first, last = int(found[1]), min(int(found[2] or len(content)), len(content) - 1)
    if first >= len(content):
        return Reply(status=416, headers={"Content-Range": f"bytes */{len(content)}"})
    headers["Content-Range"] = f"bytes {first}-{last}/{len(content)}"
    return Reply(content[first : last + 1], 206, headers, **more)


def _handler(server: WebServer) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"
        # Clients may leave connections open; s.
        timeout = 30

        def do_HEAD(self) -> None:
            self.do_GET()

        def do_GET(self) -> None:
            parts = urllib.parse.urlsplit(self.path)
            headers = {key.title(): value for key, value in self.headers.items()}
            query = dict(urllib.parse.parse_qsl(parts.query))
            request = Request(self.command, urllib.parse.unquote(parts.path), query, headers, time.monotonic())
            with server.lock:
                server.requests.append(request)
                server.busy += 1
                server.most_at_once = max(server.most_at_once, server.busy)
                reply = server.answer(request)
            # What comes meanwhile comes before this request is answered.
            time.sleep(_WORK)
            with server.lock:
                server.busy -= 1
            try:
                self._send(reply)
            except (ConnectionError, ssl.SSLError):
                self.close_connection = True

        def _send(self, reply: Reply) -> None:
            time.sleep(reply.wait)
            if reply.cut == 0:
                self.close_connection = True
                return
            self.send_response(reply.status)
            headers = {"Content-Length": str(len(reply.body)), **reply.headers}
            for name, value in headers.items():
                if value:
                    self.send_header(name, value)
            if reply.cut is not None or not headers["Content-Length"]:
                self.send_header("Connection", "close")
                self.close_connection = True
            self.end_headers()
            body = b"" if self.command == "HEAD" else reply.body[: reply.cut]
            for first in range(0, len(body), reply.step):
                self.wfile.write(body[first : first + reply.step])
                self.wfile.flush()
                time.sleep(reply.pause)

        def log_message(self, format: str, *args: object) -> None:
            """Keep quiet."""

    return Handler


@contextmanager
def web_server(certificate: Path | None = None) -> Iterator[WebServer]:
    """Run a server; with a certificate and its key in one file, over encrypted connections."""
    server = WebServer()
    service = ThreadingHTTPServer(("127.0.0.1", 0), _handler(server))
    # A connection that a client leaves open must not hold the test up.
    service.daemon_threads = True
    service.block_on_close = False
    if certificate is not None:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(certificate)
        service.socket = context.wrap_socket(service.socket, server_side=True)
        service.handle_error = lambda *_: None  # type: ignore[method-assign]
    server.url = f"{'http' if certificate is None else 'https'}://127.0.0.1:{service.server_port}"
    thread = threading.Thread(target=service.serve_forever, kwargs={"poll_interval": 0.01}, daemon=True)
    thread.start()
    try:
        yield server
    finally:
        service.shutdown()
        service.server_close()
        thread.join()


def write_certificate(path: Path) -> Path:
    """Write a certificate for this machine that nobody else has signed, and its key."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "127.0.0.1")])
    now = datetime.datetime.now(datetime.timezone.utc)
    day = datetime.timedelta(days=1)
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - day)
        .not_valid_after(now + day)
        .add_extension(x509.SubjectAlternativeName([x509.IPAddress(ipaddress.ip_address("127.0.0.1"))]), False)
        .add_extension(x509.BasicConstraints(ca=True, path_length=None), True)
        .sign(key, hashes.SHA256())
    )
    secret = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    path.write_bytes(made.public_bytes(serialization.Encoding.PEM) + secret)
    return path
