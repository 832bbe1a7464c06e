import bz2
import gzip
import lzma
import os
from collections.abc import Callable
from pathlib import Path

import osmium
import pytest
from osm_builder import document

from osm2xodr.errors import InputError
from osm2xodr.osmParsing.file import preparation
from osm2xodr.osmParsing.file.file_format import open_osm_file

ROAD = document(
    [
        '<node id="1" lat="50" lon="10"/>',
        '<node id="2" lat="50.001" lon="10"/>',
        '<way id="5"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/></way>',
    ]
)
BOMB = (
    '<?xml version="1.0"?><!DOCTYPE osm [<!ENTITY a "aaaaaaaaaa">'
    + "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True))
    + ']><osm version="0.6"><node id="1" lat="1" lon="1"><tag k="x" v="&i;"/></node></osm>'
)


def pbf(path: Path) -> bytes:
    """Make ROAD a pbf file."""
    source = path.with_name("source.osm")
    source.write_text(ROAD)
    with osmium.SimpleWriter(str(path)) as writer:
        for item in osmium.FileProcessor(str(source)):
            writer.add(item)
    return path.read_bytes()


@pytest.mark.parametrize("name", ["area.osm", "area.xml", "area", "area.osm.gz", "area.osm.pbf"])
@pytest.mark.parametrize(
    ("pack", "expected"),
    [
        (lambda raw: raw, "osm"),
        (gzip.compress, "osm.gz"),
        (bz2.compress, "osm.bz2"),
        (lambda raw: b"\xef\xbb\xbf" + raw, "osm"),
        (lambda raw: b"\r\n<!-- made <by> hand -->\n" + raw.split(b"\n", 1)[1], "osm"),
        (lambda raw: raw.decode().replace("UTF-8", "UTF-16").encode("utf-16"), "osm"),
    ],
)
def test_the_content_tells_the_format(
    tmp_path: Path, name: str, pack: Callable[[bytes], bytes], expected: str
) -> None:
    path = tmp_path / name
    path.write_bytes(pack(ROAD.encode()))
    file = open_osm_file(path)
    assert (file.format, file.deleted) == (expected, frozenset())


def test_pbf_under_any_name(tmp_path: Path) -> None:
    path = tmp_path / "area.osm"
    path.write_bytes(pbf(tmp_path / "made.osm.pbf"))
    assert open_osm_file(path).format == "pbf"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (BOMB, "document type declaration"),
        (
            (
                '<?xml version="1.0"?><!DOCTYPE osm SYSTEM "http://localhost:9/x.dtd">'
                '<osm version="0.6"><node id="1" lat="1" lon="1"><tag k="x" v="&y;"/></node></osm>'
            ),
            "document type declaration",
        ),
        (
            '<!-- <osm> --> <!DOCTYPE osm [<!ENTITY % x SYSTEM "file:///etc/passwd"> %x;]><osm version="0.6"/>',
            "external",
        ),
        ('<?xml version="1.0"?><html><body>504 Gateway Timeout</body></html>', 'a web page, not a map ("504 Gateway'),
        (
            (
                '<?xml version="1.0"?>\n<!DOCTYPE html PUBLIC "a" "b"><html><head><title>OSM3S</title></head><body>'
                f"<p>{'The data is made available under ODbL. ' * 4}</p><p><strong>Error</strong>: runtime error: "
                f"{'open64 ' * 12}The server is probably too busy to handle your request.</p></body></html>"
            ),
            "The server is probably too busy to handle your request.",
        ),
        ("<html><head><title>502 Bad Gateway</title></head><body></body></html>", '("502 Bad Gateway"); if'),
        ("<osmError><message>The maximum bbox size is 0.25</message></osmError>", "The maximum bbox size is 0.25"),
        ("You requested too many nodes (limit is 50000).", 'a text ("You requested too many nodes'),
        ('{"message": "Rate limit exceeded"}', "Rate limit exceeded"),
        ('<?xml version="1.0"?><osmChange version="0.6"/>', "XML of another kind (<osmChange>"),
        ('<?xml version="1.0"?>', "is no OSM data or incomplete"),
        ("<" + " " * (1 << 20) + "osm>", "is no OSM data or incomplete"),
        ('{"version": 0.6, "elements": []}', "is JSON; ask Overpass for XML, [out:xml] in place of [out:json]"),
        ("hello " * 100, "is no OSM data"),
        ("\x00" * 5000, "is no OSM data"),
        ("", "is empty"),
    ],
)
@pytest.mark.parametrize("compress", [False, True])
def test_what_is_refused(tmp_path: Path, text: str, reason: str, compress: bool) -> None:
    path = tmp_path / "area.osm"
    path.write_bytes(gzip.compress(text.encode()) if compress else text.encode())
    with pytest.raises(InputError) as caught:
        open_osm_file(path)
    message = str(caught.value)
    assert str(path) in message
    assert "\n" not in message
    # A compressed file that is empty is not.
    assert reason in message or (compress and not text and "is no OSM data" in message)


@pytest.mark.parametrize(
    ("head", "what"),
    [
        (b"II*\0\x08\0\0\0", "a TIFF raster"),
        (b"\x89PNG\r\n", "a picture"),
        (b"7z\xbc\xaf", "compressed in a way that is not supported"),
        (b"\xff\xe0\x04o5m2", "in the format o5m"),
    ],
)
def test_files_of_another_kind_are_named(tmp_path: Path, head: bytes, what: str) -> None:
    path = tmp_path / "area.osm"
    path.write_bytes(head + b"\0" * 100)
    with pytest.raises(InputError) as caught:
        open_osm_file(path)
    assert str(caught.value) == f"{path} is {what}; give OSM data as .osm or .osm.pbf"


def test_what_cannot_be_opened(tmp_path: Path) -> None:
    for path, reason in ((tmp_path / "none.osm", "does not exist"), (tmp_path, "is a directory")):
        with pytest.raises(InputError) as caught:
            open_osm_file(path)
        assert str(caught.value).startswith(f"{path} {reason}; ")
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(InputError, match="is no regular file"):
        open_osm_file(pipe)


def test_without_permission(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    path = tmp_path / "area.osm"
    path.write_text(ROAD)
    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(InputError) as caught:
        open_osm_file(path)
    assert str(caught.value) == f"{path} cannot be read (Permission denied); check its permissions"


@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress])
def test_truncated_archives(tmp_path: Path, pack: Callable[[bytes], bytes]) -> None:
    path = tmp_path / "area.osm.x"
    path.write_bytes(pack(ROAD.encode())[:60])
    with pytest.raises(InputError, match=r"damaged or incomplete|no OSM data or incomplete"):
        open_osm_file(path)


@pytest.fixture
def early(monkeypatch: pytest.MonkeyPatch) -> None:
    """Look at sizes from 1 MB on: files that are larger make for slow tests."""
    monkeypatch.setattr(preparation, "RATIO_CHECKED_FROM", 1 << 20)


@pytest.mark.usefixtures("early")
@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress, lzma.compress])
def test_what_becomes_far_larger_than_map_data_do_is_refused(tmp_path: Path, pack: Callable[[bytes], bytes]) -> None:
    path = tmp_path / "area.osm"
    path.write_bytes(pack(document(['<node id="1" lat="50" lon="10"/>\n' * 200_000]).encode()))
    assert path.stat().st_size < 30_000
    with pytest.raises(InputError) as caught:
        open_osm_file(path)
    assert str(caught.value).startswith(f"{path} holds over 200 times its own size, which map data does not; give")


@pytest.mark.usefixtures("early")
@pytest.mark.parametrize("pack", [gzip.compress, bz2.compress])
def test_compressed_maps_are_not_too_large(tmp_path: Path, pack: Callable[[bytes], bytes]) -> None:
    nodes = [f'<node id="{k}" lat="{40 + k * 7919 % 9973 / 1e3}" lon="{k / 1e4}"/>' for k in range(40_000)]
    path = tmp_path / "area.osm"
    path.write_bytes(pack(document(nodes).encode()))
    assert open_osm_file(path).deleted == frozenset()


@pytest.mark.parametrize("pack", [bytes, gzip.compress, bz2.compress])
def test_what_an_editor_has_deleted(tmp_path: Path, pack: Callable[[bytes], bytes]) -> None:
    text = document(
        [
            '<node id="1" action="modify" lat="50" lon="10"/>',
            "<node id='-7' action='delete' lat='50' lon='10'/>",
            '<way id="5" visible="true" action = "delete"><nd ref="1"/></way>',
            '<relation action="delete" id="9"><tag k="note" v="delete me"/></relation>',
        ]
    )
    path = tmp_path / "area.osm"
    path.write_bytes(pack(text.encode()))
    assert open_osm_file(path).deleted == {("node", -7), ("way", 5), ("relation", 9)}


def test_the_word_alone_deletes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "area.osm"
    path.write_text(document(['<node id="1" lat="50" lon="10"><tag k="note" v="delete"/></node>']))
    assert open_osm_file(path).deleted == frozenset()


@pytest.mark.parametrize(
    ("added", "said"),
    [
        ("<remark> runtime error: Query timed out after 25 seconds. </remark>", "Query timed out after 25 seconds"),
        ("<error>You requested too many nodes</error>", "You requested too many nodes"),
        ("<remark>The query has no settings.</remark>", None),
        ("<note>The data is from OpenStreetMap; error</note>", None),
    ],
)
@pytest.mark.parametrize("pack", [bytes, gzip.compress])
def test_maps_that_the_server_did_not_send_in_full(
    tmp_path: Path, added: str, said: str | None, pack: Callable[[bytes], bytes]
) -> None:
    path = tmp_path / "area.osm"
    path.write_bytes(pack(ROAD.replace("</osm>", f"{added}</osm>").encode()))
    file = open_osm_file(path)
    file.require_whole(True)
    if said is None:
        file.require_whole(False)
        return
    with pytest.raises(InputError) as caught:
        file.require_whole(False)
    assert said in str(caught.value)
    assert str(caught.value).endswith("or take what there is with --allow-partial")
