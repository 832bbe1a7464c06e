from osm2xodr.system import is_page, plain_text


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
