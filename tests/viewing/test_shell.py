"""The shell of pages: what its policy allows, what is escaped, and what fills a template."""

from __future__ import annotations

import base64
import hashlib
import re

import pytest

from osm2xodr.viewing import facts, filled, page_html

HOSTILE = "</title><script>alert('&')</script>"


def policy_of(page: str) -> dict[str, list[str]]:
    """Return the directives of a page's content security policy."""
    found = re.search(r'<meta http-equiv="Content-Security-Policy" content="([^"]*)">', page)
    assert found is not None
    words = [directive.split() for directive in found[1].split(";")]
    return {name: sources for name, *sources in words}


def allowed(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def test_the_policy_allows_the_scripts_and_the_style_of_the_page_alone() -> None:
    page = page_html("x", "", "p { margin: 0 }", scripts=("one();", "two();"), early_script="now();").decode()
    style = re.search(r"<style>(.*)</style>", page, re.DOTALL)
    assert style is not None
    assert style[1].endswith("p { margin: 0 }")
    assert re.findall(r"<script>(.*)</script>", page) == ["now();", "one();", "two();"]
    assert policy_of(page) == {
        "default-src": ["'none'"],
        "script-src": [allowed("now();"), allowed("one();"), allowed("two();")],
        "style-src": [allowed(style[1])],
        "img-src": ["data:"],
        "base-uri": ["'none'"],
        "form-action": ["'none'"],
    }


def test_a_page_without_scripts_allows_none() -> None:
    page = page_html("x", "<p>y</p>", "").decode()
    assert policy_of(page)["script-src"] == ["'none'"]
    assert "<script" not in page
    assert "<!--" not in page


def test_scripts_from_blobs_are_allowed_where_they_are_wanted() -> None:
    policy = policy_of(page_html("x", "", "", scripts=("one();",), blob_scripts=True).decode())
    assert policy["script-src"] == [allowed("one();"), "blob:"]
    assert policy["img-src"] == ["data:", "blob:"]


def test_titles_and_facts_are_escaped() -> None:
    page = page_html(HOSTILE, facts([(HOSTILE, HOSTILE)]), "").decode()
    assert "<script" not in page
    assert page.count("&lt;/title&gt;&lt;script&gt;alert(&#x27;&amp;&#x27;)&lt;/script&gt;") == 3


def test_licences_cannot_end_their_comment() -> None:
    page = page_html("x", "", "", licences=("MIT --> <script>", "  BSD ")).decode()
    assert "<!--\nMIT - -> <script>\n\nBSD\n-->\n" in page


def test_a_title_with_half_a_character_is_written() -> None:
    assert b"<title>a?b</title>" in page_html("a\udc80b", "", "")


def test_places_in_parts_are_not_filled() -> None:
    assert filled("@a@, @b@ and a@example.org", {"a": "@b@", "b": "@a@"}) == "@b@, @a@ and a@example.org"
    page = page_html("@body@ @policy@", "@title@ @scripts@", "").decode()
    assert "<title>@body@ @policy@</title>" in page
    assert "@title@ @scripts@" in page


def test_a_place_without_a_part_is_an_error() -> None:
    with pytest.raises(KeyError):
        filled("@a@", {})
