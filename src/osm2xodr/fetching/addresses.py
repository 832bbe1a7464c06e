"""Addresses of web servers."""

from __future__ import annotations

import re
import string
import urllib.parse

from osm2xodr.errors import OptionError


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
