"""Requests over HTTP: polite, patient, and with errors that say in one sentence what is wrong.

By the standard library. A further library would bring nothing that is missed here: requests are made one at a time,
and what matters (pauses, downloads that go on, answers that are not what they should be) is the same work with any.
"""

from __future__ import annotations

import email.utils
import http.client
import re
import socket
import ssl
import time
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final, TypeVar

from osm2xodr.errors import OptionError
from osm2xodr.fetching.defaults import LEAST_RATE, USER_AGENT
from osm2xodr.fetching.options import Network, ServerError
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


class _AgainError(Exception):
    """A request failed in a way that may pass."""

    def __init__(self, what: str, status: int = 0, after: float | None = None) -> None:
        super().__init__(what)
        self.status = status
        self.after = after  # How long the server asks to wait, s


class _Redirects(urllib.request.HTTPRedirectHandler):
    """Follows redirects to web servers alone, and not from an encrypted connection to an open one."""

    def http_error_302(self, req: Any, fp: Any, code: int, msg: str, headers: Any) -> Any:
        """Follow one."""
        new = urllib.parse.urljoin(req.full_url, headers.get("Location", ""))
        wanted = ("https",) if req.type == "https" else ("http", "https")
        if urllib.parse.urlsplit(new).scheme not in wanted:
            fp.close()
            raise ServerError(f"{shown(req.full_url)} leads to {new}, which is not followed; give another address")
        return super().http_error_302(req, fp, code, msg, headers)

    http_error_301 = http_error_303 = http_error_307 = http_error_308 = http_error_302

    def redirect_request(self, req: Any, fp: Any, code: int, msg: str, headers: Any, newurl: str) -> Any:
        """Return the request to follow with."""
        # Python before 3.11 does not know 308, which is for requests such as ours the same.
        return super().redirect_request(req, fp, 307 if code == 308 else code, msg, headers, newurl)


class Connection:
    """Makes requests one at a time."""

    def __init__(self, network: Network) -> None:
        self.network = network
        self._opener = urllib.request.build_opener(_Redirects())
        # Neither files nor other protocols, wherever an address comes from.
        handlers: Any = self._opener
        for kind in ("file", "ftp", "data"):
            handlers.handle_open.pop(kind, None)
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
                request = urllib.request.Request(url, headers=dict(headers()))
                with self._opener.open(request, timeout=network.patience + silence) as response:
                    return read(response)
            except _AgainError as error:
                problem = error
            except urllib.error.HTTPError as error:
                problem = _status_problem(url, option, error)
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
        length = response.headers.get("Content-Length", "")
        expected = int(length) if length.isdigit() else None
        received = since = 0
        mark = time.monotonic()
        try:
            while chunk := response.read1(_CHUNK):
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


def again(what: str) -> Exception:
    """Return what `read` raises where the answer is not whole, and the request may be made again."""
    return _AgainError(what)


def _cut(received: int, expected: int | None, silent: bool = False) -> str:
    of = "" if expected is None else f" of {expected:,}"
    return f"{'fell silent' if silent else 'cut the connection'} after {received:,}{of} bytes"


def _status_problem(url: str, option: str, error: urllib.error.HTTPError) -> _AgainError:
    """Return why an answer with an error may pass; raise `ServerError` for others."""
    with error:
        try:
            said = plain_text(error.read(_ERROR_READ))
        except (OSError, http.client.HTTPException):
            said = ""
    if error.code in _BUSY:
        what = {429: "has too many requests of this machine", 504: "is too busy"}.get(error.code, "has an error")
        return _AgainError(
            f"{what} (status {error.code})", error.code, _retry_after(error.headers.get("Retry-After"))
        )
    quoted = f": {said}" if said else ""
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
    if isinstance(reason, (http.client.HTTPException, ConnectionResetError, ConnectionAbortedError, BrokenPipeError)):
        return _AgainError("cut the connection")
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
    if text.strip().isdigit():
        return float(text)
    try:
        at = email.utils.parsedate_to_datetime(text)
    except ValueError:
        return None
    return max(0.0, at.timestamp() - time.time())


def check_address(option: str, url: str) -> None:
    """Raise `OptionError` unless an address is one of a web server."""
    parts = urllib.parse.urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.hostname or not re.fullmatch(r"[!-~]+", url):
        raise OptionError(f"{option} {url} is no address; give one that begins with https://", option)


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
