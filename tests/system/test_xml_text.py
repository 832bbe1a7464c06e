import gzip
import io

import pytest

from osm2xodr.system import xml_stream


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
