"""What servers say to people where data was asked for: web pages, and messages in plain text, XML or JSON."""

from __future__ import annotations

import re
from html import unescape
from typing import Final

# How much is quoted, characters: the longest message of the Overpass API about its load has some 160.
_QUOTED: Final = 240
_MARKUP: Final = re.compile(r"(?is)<(script|style|head)\b.*?</\1\s*>|<\?.*?\?>|<!--.*?-->|<[^>]*>")
_TITLE: Final = re.compile(r"(?is)<title\b[^>]*>(.*?)</title")
# Where the message begins on pages that have other sentences first, as those of the Overpass API do.
_ERROR: Final = re.compile(r"\berror\b", re.IGNORECASE)


def is_page(head: bytes) -> bool:
    """Return whether content begins like a web page."""
    start = head[:1024].lstrip(b"\xef\xbb\xbf \t\r\n").lower()
    return start.startswith((b"<!doctype html", b"<html")) or b"<html" in start


def plain_text(content: bytes | str) -> str:
    """Return the beginning of what a page or a message says to people, in one line."""
    text = content if isinstance(content, str) else content.decode("utf-8", "replace")
    words = _one_line(_MARKUP.sub(" ", text))
    if not words and (title := _TITLE.search(text)):
        words = _one_line(title[1])
    if len(words) <= _QUOTED:
        return words
    if found := _ERROR.search(words):
        words = words[found.start() :]
    return words if len(words) <= _QUOTED else words[: _QUOTED - 3].rstrip() + "..."


def _one_line(text: str) -> str:
    return " ".join("".join(sign if sign.isprintable() else " " for sign in unescape(text)).split())
