"""Texts of others: XML as expat and libxml2 take it, and what servers say to people where data was asked for.

XML is unpacked, and gets a declaration that is spelt by the book: files edited by hand or written by scripts have
blank lines or a licence before it, or call UTF-8 "utf8". Other readers pass over that. Servers answer with web pages,
and with messages in plain text, XML or JSON.
"""

from __future__ import annotations

import codecs
import gzip
import io
import re
from html import unescape
from typing import BinaryIO, Final, NamedTuple, cast

# Bytes at the start of a file in which its declaration stands.
_DECLARATION_IN: Final = 1 << 16
# What files have before it; XML allows nothing there (XML 1.0, 2.8).
_BEFORE: Final = re.compile(rb"(?:\s|<!--.*?-->)+(?=<\?xml\s)", re.DOTALL)
_ENCODING: Final = re.compile(rb"""(<\?xml\s[^>]*?encoding\s*=\s*["'])([^"'>]*)""")
# What expat reads by itself, by Python's names.
_BY_EXPAT: Final = frozenset({"utf-8", "utf-16", "ascii", "iso8859-1"})
_GZIP: Final = b"\x1f\x8b"  # RFC 1952, 2.3.1
_UTF_8: Final = (b"utf-8", b"us-ascii", b"ascii")

# How much is quoted, characters: the longest message of the Overpass API about its load has some 160.
_QUOTED: Final = 240
_MARKUP: Final = re.compile(r"(?is)<(script|style|head)\b.*?</\1\s*>|<\?.*?\?>|<!--.*?-->|<[^>]*>")
_TITLE: Final = re.compile(r"(?is)<title\b[^>]*>(.*?)</title")
# Where the message begins on pages that have other sentences first, as those of the Overpass API do.
_ERROR: Final = re.compile(r"\berror\b", re.IGNORECASE)


class _Declared(NamedTuple):
    """The start of a file as it should be, and what its text has to be decoded from, if anything."""

    head: bytes
    codec: str | None


def xml_stream(stream: BinaryIO) -> BinaryIO:
    """Return the text of an XML file; it is `stream` itself where that can be read as it is.

    `stream` is at its start, and may be packed by gzip where it can seek. LookupError if Python does not know the
    declared encoding; reading raises ValueError where the text is not in it.
    """
    if stream.seekable():
        packed = stream.read(len(_GZIP)) == _GZIP
        stream.seek(0)
        stream = cast("BinaryIO", gzip.GzipFile(fileobj=stream, mode="rb")) if packed else stream
    head = stream.read(_DECLARATION_IN)
    found = _declared(head)
    if found == (head, None) and stream.seekable():
        stream.seek(0)
        return stream
    return cast("BinaryIO", _Mended(found, stream))


def _declared(head: bytes) -> _Declared:
    bom = codecs.BOM_UTF8 if head.startswith(codecs.BOM_UTF8) else b""
    before = _BEFORE.match(head, len(bom))
    skipped = before[0] if before else b""
    rest = head[len(bom) + len(skipped) :]
    codec = None
    if (found := _ENCODING.match(rest)) and found[2].lower() not in _UTF_8:
        name = codecs.lookup(found[2].decode("latin-1")).name
        if name == "utf-8" or name not in _BY_EXPAT:
            b" ".decode(name, "replace")  # A LookupError for what is no encoding of text, such as "zip"
            codec = None if name == "utf-8" else name
            rest = found[1] + b"UTF-8" + rest[found.end() :]
    # Behind the declaration, so that lines keep their numbers.
    end = rest.find(b"?>") + len(b"?>") if skipped else 0
    return _Declared(bom + rest[:end] + skipped + rest[end:], codec)


class _Mended(io.RawIOBase):
    """A stream with another start."""

    def __init__(self, start: _Declared, rest: BinaryIO) -> None:
        self._rest = rest
        self._decoder = codecs.getincrementaldecoder(start.codec)() if start.codec else None
        self._ready = self._decoded(start.head)

    def readable(self) -> bool:
        """Return whether it can be read."""
        return True

    def read(self, size: int = -1) -> bytes:
        """Read about `size` bytes, none at the end; all that is left if it is negative."""
        out, self._ready = self._ready, b""
        while size < 0 or not out:
            raw = self._rest.read(size)
            out += self._decoded(raw)
            if not raw:
                break
        if size >= 0:
            out, self._ready = out[:size], out[size:]
        return out

    def _decoded(self, raw: bytes) -> bytes:
        return raw if self._decoder is None else self._decoder.decode(raw, final=not raw).encode()


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
