"""Requests over HTTP: polite, patient, and with errors that say in one sentence what is wrong; addresses of servers.

By the standard library. A further library would bring nothing that is missed here: requests are made one at a time,
and what matters (pauses, downloads that go on, answers that are not what they should be) is the same work with any.
"""

from __future__ import annotations

import email.utils
import http.client
import io
import re
import socket
import ssl
import string
import time
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, Final, TypeVar

from osm2xodr.errors import OptionError
from osm2xodr.fetching.options import LEAST_RATE, USER_AGENT, Network, ServerError
from osm2xodr.system import plain_text

_Read = TypeVar("_Read")
Response = Any  # An answer, `http.client.HTTPResponse`

# Answers after which the same request may succeed (RFC 9110 and RFC 6585).
_BUSY: Final = frozenset({408, 429, 500, 502, 503, 504})
# Longest pause that a server may ask for, s; a choice. Beyond it the user should decide.
_WAIT_MAX: Final = 600.0
# Bytes that are read at a time, and of an answer that is an error.
_CHUNK: Final = 1 << 16
_ERROR_READ: Final = 1 << 14

# What headers hold where it is of use (RFC 9110, 8.6, 10.2.3 and 14.4); no size of a file has more digits.
_NUMBER: Final = re.compile(r"[0-9]{1,15}")
_RANGE: Final = re.compile(r"bytes ([0-9]{1,15})-[0-9]{1,15}/([0-9]{1,15}|\*)")
_MARK: Final = re.compile(r"[ -~]{1,200}")
# Status of an answer that is a part of a file.
_PART: Final = 206


class _AgainError(Exception):
    """A request failed in a way that may pass."""

    def __init__(self, what: str, status: int = 0, after: float | None = None) -> None:
        super().__init__(what)
        self.status = status
        self.after = after  # How long the server asks to wait, s


class _Clock(io.RawIOBase):
    """What a server sends, read until its time is up; each read of a socket alone would begin to wait anew."""

    def __init__(self, connection: socket.socket, silence: float, patience: float) -> None:
        self._socket = connection
        self._raw = connection.makefile("rb", buffering=0)
        self._patience: float | None = patience
        self.give(silence)

    def give(self, seconds: float) -> None:
        """Give the server some time from now on, s."""
        self._until = time.monotonic() + seconds

    def readable(self) -> bool:
        """Say that it is for reading."""
        return True

    def readinto(self, buffer: Any) -> int | None:
        """Read what is there."""
        left = self._until - time.monotonic()
        if left <= 0.0:
            raise TimeoutError
        self._socket.settimeout(left)
        count = self._raw.readinto(buffer)
        if self._patience is not None:
            # It has begun to answer: the status line and all headers are to come soon.
            self.give(self._patience)
            self._patience = None
        return count

    def close(self) -> None:
        """Let go of the connection."""
        self._raw.close()
        super().close()


class _Response(http.client.HTTPResponse):
    """An answer whose reading has a clock."""

    def __init__(self, connection: socket.socket, *args: Any, silence: float, patience: float, **more: Any) -> None:
        super().__init__(connection, *args, **more)
        plain, self.clock = self.fp, _Clock(connection, silence, patience)
        self.fp = io.BufferedReader(self.clock)
        plain.close()


class _WebHandler(urllib.request.HTTPHandler, urllib.request.HTTPSHandler):
    """Makes connections whose answers have clocks; connecting takes no longer than patience."""

    def __init__(self, patience: float) -> None:
        super().__init__()
        self._patience = patience
        # Loading certificates takes as long as a request.
        self._context: ssl.SSLContext | None = None

    def http_open(self, req: urllib.request.Request) -> Any:
        """Open an open connection."""
        return self.do_open(partial(self._made, http.client.HTTPConnection), req)

    def https_open(self, req: urllib.request.Request) -> Any:
        """Open an encrypted connection."""
        if self._context is None:
            self._context = ssl.create_default_context()
            self._context.set_alpn_protocols(["http/1.1"])
        return self.do_open(partial(self._made, http.client.HTTPSConnection, context=self._context), req)

    def _made(self, kind: Callable[..., Any], host: str, timeout: float, **more: Any) -> Any:
        made = kind(host, timeout=self._patience, **more)
        made.response_class = partial(_Response, silence=timeout, patience=self._patience)
        return made


class _Redirects(urllib.request.HTTPRedirectHandler):
    """Follows redirects to web servers alone, and not from an encrypted connection to an open one."""

    def http_error_302(self, req: Any, fp: Any, code: int, msg: str, headers: Any) -> Any:
        """Follow one; what leads nowhere, or has led too far, is the error that it is."""
        count, location = getattr(req, "redirects", 0) + 1, headers.get("Location")
        if location is None or count > self.max_redirections:
            return None
        fp.close()
        new = joined(req.full_url, location)
        if new is None or (req.type == "https" and not new.startswith("https:")):
            leads = plain_text(location)
            raise ServerError(f"{shown(req.full_url)} leads to {leads}, which is not followed; give another address")
        request = urllib.request.Request(new, headers=req.headers, unverifiable=True)
        request.redirects = count  # type: ignore[attr-defined]
        return self.parent.open(request, timeout=req.timeout)

    http_error_301 = http_error_303 = http_error_307 = http_error_308 = http_error_302


class Connection:
    """Makes requests one at a time."""

    def __init__(self, network: Network) -> None:
        self.network = network
        # Neither files nor other protocols, wherever an address comes from.
        self._opener = urllib.request.OpenerDirector()
        for handler in (
            urllib.request.ProxyHandler(),
            urllib.request.UnknownHandler(),
            _WebHandler(network.patience),
            urllib.request.HTTPDefaultErrorHandler(),
            _Redirects(),
            urllib.request.HTTPErrorProcessor(),
        ):
            self._opener.add_handler(handler)
        self._opener.addheaders = [("User-Agent", USER_AGENT), ("Accept", "*/*")]

    def ask(
        self,
        url: str,
        option: str,
        read: Callable[[Response], _Read],
        headers: Callable[[], Mapping[str, str]] = dict,
        silence: float = 0.0,
    ) -> _Read:
        """Return what `read` makes of the answer from an address; several requests are made where that helps.

        `option` has given the address, for messages. `headers` are asked for before each request. The server may be
        silent for `silence`, s, longer than usual. Raises `ServerError`.
        """
        network = self.network
        for attempt in range(network.retries + 1):
            try:
                with self._open(url, headers(), network.patience + silence) as response:
                    return read(response)
            except _AgainError as error:
                problem = error
            except urllib.error.HTTPError as error:
                problem = _status_problem(url, option, error, network.patience)
            except urllib.error.URLError as error:
                problem = _reach_problem(url, option, error.reason)
            except (http.client.HTTPException, ConnectionError, TimeoutError, ssl.SSLError, socket.gaierror) as error:
                problem = _reach_problem(url, option, error)
            if attempt < network.retries:
                self._pause(url, option, problem, attempt)
        raise ServerError(
            f"{shown(url)} {problem}, also after {network.retries} further tries; try again later, the same command "
            f"goes on where it ended, or give another address with {option}",
            problem.status,
        )

    def _open(self, url: str, headers: Mapping[str, str], timeout: float) -> Response:
        try:
            return self._opener.open(urllib.request.Request(url, headers=dict(headers)), timeout=timeout)
        except ValueError as error:
            # Of the parts of the standard library that read addresses and headers.
            why = plain_text(str(error))
            raise ServerError(
                f"{shown(url)} gives an answer that is not HTTP ({why}); give another address"
            ) from error

    def _pause(self, url: str, option: str, problem: _AgainError, attempt: int) -> None:
        """Wait before a request is made again."""
        seconds = self.network.pause * 2.0**attempt if problem.after is None else problem.after
        if seconds > _WAIT_MAX:
            raise ServerError(
                f"{shown(url)} {problem} and asks to wait {seconds / 60.0:.0f} minutes; try again then, or give "
                f"another address with {option}",
                problem.status,
            )
        self.network.note(f"{host(url)} {problem}; it is asked again in {seconds:.0f} s")
        self.network.sleep(seconds)

    def chunks(self, response: Response) -> Iterator[bytes]:
        """Yield the content of an answer; it is all there when this ends."""
        expected = length_of(response)
        received = since = 0
        mark = time.monotonic()
        try:
            while chunk := self._next(response):
                received += len(chunk)
                since += len(chunk)
                now = time.monotonic()
                if now - mark > self.network.patience:
                    if since < LEAST_RATE * (now - mark):
                        raise _AgainError(f"sends less than {LEAST_RATE / 1e3:.0f} kB/s")
                    mark, since = now, 0
                yield chunk
        except (http.client.HTTPException, ConnectionError, TimeoutError, ssl.SSLError) as error:
            raise _AgainError(_cut(received, expected, isinstance(error, TimeoutError))) from error
        if expected is not None and received < expected:
            raise _AgainError(_cut(received, expected))

    def _next(self, response: Response) -> bytes:
        response.clock.give(self.network.patience)
        content: bytes = response.read1(_CHUNK)
        return content


def length_of(response: Response) -> int | None:
    """Return how many bytes an answer is to have; None if it does not say."""
    length = response.headers.get("Content-Length", "").strip()
    return int(length) if _NUMBER.fullmatch(length) else None


def range_of(response: Response) -> tuple[int, int | None]:
    """Return where an answer begins in its file, and the length of the file if it is known, bytes."""
    if response.status != _PART:
        return 0, length_of(response)
    found = _RANGE.fullmatch(response.headers.get("Content-Range", "").strip())
    if found is None:
        return -1, None
    return int(found[1]), None if found[2] == "*" else int(found[2])


def mark_of(response: Response) -> str:
    """Return by what a file is known again (RFC 9110, 13.1.5); empty if it is by nothing."""
    etag = response.headers.get("ETag", "")
    mark = etag if etag and not etag.startswith("W/") else response.headers.get("Last-Modified", "")
    return mark if _MARK.fullmatch(mark) else ""


def again(what: str) -> Exception:
    """Return what `read` raises where the answer is not whole, and the request may be made again."""
    return _AgainError(what)


def _cut(received: int, expected: int | None, silent: bool = False) -> str:
    of = "" if expected is None else f" of {expected:,}"
    return f"{'fell silent' if silent else 'cut the connection'} after {received:,}{of} bytes"


def _status_problem(url: str, option: str, error: urllib.error.HTTPError, patience: float) -> _AgainError:
    """Return why an answer with an error may pass; raise `ServerError` for others."""
    with error:
        try:
            clock = getattr(error.fp, "clock", None)
            if clock is not None:
                clock.give(patience)
            message = plain_text(error.read(_ERROR_READ))
        except (OSError, http.client.HTTPException):
            message = ""
    if error.code in _BUSY:
        what = {429: "has too many requests of this machine", 504: "is too busy"}.get(error.code, "has an error")
        return _AgainError(
            f"{what} (status {error.code})", error.code, _retry_after(error.headers.get("Retry-After"))
        )
    quoted = f": {message}" if message else ""
    raise ServerError(
        f"{shown(url)} answers with status {error.code}{quoted}; check the address, or give another one with "
        f"{option}",
        error.code,
    ) from error


def _reach_problem(url: str, option: str, reason: Any) -> _AgainError:
    """Return why a server that was not reached may be the next time; raise `ServerError` where it will not."""
    other = f"give another address with {option}"
    if isinstance(reason, ssl.SSLCertVerificationError):
        why = (reason.verify_message or str(reason)).rstrip(".")
        raise ServerError(
            f"{shown(url)} does not prove that it is {host(url)} ({why}); set SSL_CERT_FILE to the certificates of "
            f"your network, or {other}"
        ) from reason
    if isinstance(reason, ssl.SSLError):
        why = (reason.reason or str(reason)).replace("_", " ").lower()
        raise ServerError(f"{shown(url)} cannot be reached over an encrypted connection ({why}); {other}") from reason
    if isinstance(reason, TimeoutError):
        return _AgainError("does not answer")
    cuts = (http.client.IncompleteRead, ConnectionResetError, ConnectionAbortedError, BrokenPipeError)
    if isinstance(reason, cuts):
        return _AgainError("cut the connection")
    if isinstance(reason, http.client.HTTPException):
        return _AgainError("gives an answer that is not HTTP")
    why = str(getattr(reason, "strerror", None) or reason).lower()
    raise ServerError(
        f"{shown(url)} cannot be reached ({why}): this machine may be offline; connect it, {other}, or use files "
        "that you have",
        unreached=why,
    ) from (reason if isinstance(reason, BaseException) else None)


def _retry_after(text: str | None) -> float | None:
    """Return how long a server asks to wait, s (RFC 9110, 10.2.3); None if it does not say."""
    if text is None:
        return None
    if _NUMBER.fullmatch(text.strip()):
        return float(text)
    try:
        return max(0.0, email.utils.parsedate_to_datetime(text).timestamp() - time.time())
    except (ValueError, TypeError, LookupError, OverflowError, OSError):
        # Versions of Python differ in what they make of texts that are no dates.
        return None


def check_address(option: str, url: str) -> None:
    """Raise `OptionError` unless an address is one of a web server."""
    if not is_web(url):
        raise OptionError(f"{option} {url} is no address; give one that begins with https://", option)


def is_web(url: str) -> bool:
    """Whether an address is one of a web server."""
    try:
        parts = urllib.parse.urlsplit(url)
        # Both fail where they are none.
        known = parts.hostname and parts.hostname.encode("idna") and parts.port != 0
    except ValueError:
        return False
    return bool(known) and parts.scheme in ("http", "https") and re.fullmatch(r"[!-~]+", url) is not None


def joined(base: str, location: str) -> str | None:
    """Return the address that a redirect leads to; None if it is none of a web server."""
    try:
        new = urllib.parse.urljoin(
            base, urllib.parse.quote(location.strip(), safe=string.punctuation, encoding="latin-1")
        )
    except ValueError:
        return None
    return new if is_web(new) else None


def is_address(text: str) -> bool:
    """Return whether a text is meant as an address rather than a file."""
    return re.match(r"[a-zA-Z][a-zA-Z0-9+.-]*://", text) is not None


def host(url: str) -> str:
    """Return the name of a server, with its port where that is unusual."""
    return urllib.parse.urlsplit(url).netloc.rpartition("@")[2]


def shown(url: str) -> str:
    """Return an address for messages, without a query and without a password."""
    parts = urllib.parse.urlsplit(url)
    return urllib.parse.urlunsplit((parts.scheme, host(url), parts.path, "", ""))
