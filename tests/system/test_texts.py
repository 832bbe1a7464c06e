""" """

from __future__ import annotations

import gzip
import io

import pytest

from osm2xodr.system import is_page, plain_text, xml_stream


@pytest.mark.parametrize("size", [-1, 7])
@pytest.mark.parametrize(
    ("raw", "mended"),
    [
        (b'<?xml version="1.0" encoding="utf8"?><a/>', b'<?xml version="1.0" encoding="UTF-8"?><a/>'),
        (b'\n\n<!-- b -->\n<?xml version="1.0"?>\n<a/>', b'<?xml version="1.0"?>\n\n<!-- b -->\n\n<a/>'),
        (
            b"<?xml version='1.0' encoding='cp1252'?><a b='\x80'/>",
            "<?xml version='1.0' encoding='UTF-8'?><a b='\u20ac'/>".encode(),
        ),
    ],
)
def test_declarations_become_what_parsers_take(raw: bytes, mended: bytes, size: int) -> None:
    for packed in (raw, gzip.compress(raw)):
        stream = xml_stream(io.BytesIO(packed))
        out = b""
        while more := stream.read(size):
            out += more
        assert out == mended


@pytest.mark.parametrize("raw", [b"<a/>", b'<?xml version="1.0" encoding="UTF-8"?><a/>', b"", b"<!-- b --><a/>"])
def test_other_files_are_read_as_they_are(raw: bytes) -> None:
    stream = io.BytesIO(raw)
    assert xml_stream(stream) is stream
    assert stream.read() == raw


@pytest.mark.parametrize("name", ["zip", "hex", "klingon"])
def test_only_encodings_of_text_are_known(name: str) -> None:
    with pytest.raises(LookupError):
        xml_stream(io.BytesIO(f'<?xml version="1.0" encoding="{name}"?><a/>'.encode()))


def test_messages_hold_no_markup() -> None:
    assert plain_text(b"<p>a &amp; b\x1b[0m</p><script>x()</script> <!-- c -->\n d") == "a & b [0m d"
    assert plain_text(b"x" * 1000) == "x" * 237 + "..."


def test_what_has_no_words_says_its_title() -> None:
    assert plain_text("<html><head><title>502\nBad Gateway</title></head><body/></html>") == "502 Bad Gateway"


def test_long_pages_are_quoted_from_their_error_on() -> None:
    assert plain_text("licence " * 50 + "<b>Error</b>: too busy") == "Error : too busy"


def test_pages_are_told_from_maps() -> None:
    assert is_page(b"\n<!DOCTYPE HTML><p>x")
    assert is_page(b'<?xml version="1.0"?><html>')
    assert not is_page(b'<?xml version="1.0"?><osm version="0.6">')
