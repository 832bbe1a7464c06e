"""The shell that all pages share: one file of HTML that needs no other file and no network.

Its content security policy names the scripts and the style by their hashes and forbids everything else, so that text
from a file that did get into the page as markup could neither run nor load anything. Imports nothing heavy.
"""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files


def page_html(
    title: str,
    body: str,
    style: str,
    *,
    scripts: Sequence[str] = (),
    early_script: str = "",
    blob_scripts: bool = False,
    licences: Sequence[str] = (),
) -> bytes:
    """Return a page, HTML in UTF-8; the same arguments give the same bytes.

    Parameters
    ----------
    title
        Plain text.
    body
        HTML, in which the caller has escaped what comes from files.
    style
        CSS of this page, which follows the style that all pages share.
    scripts
        JavaScript, run in this order after the body.
    early_script
        JavaScript that is run before the body is read.
    blob_scripts
        Whether scripts may load further ones from addresses ``blob:``, which only the page itself can make.
    licences
        Texts of the licences of the libraries in the page.
    """
    style = f"{package_text('osm2xodr.viewing', 'template/shell.css')}\n{style}"
    hashes = [_policy_hash(script) for script in (early_script, *scripts) if script]
    sources = " ".join([*hashes, *(["blob:"] if blob_scripts else [])]) or "'none'"
    # Two hyphens would end the comment.
    notice = "\n\n".join(text.strip() for text in licences).replace("--", "- -")
    head = f"<!--\n{notice}\n-->\n" if notice else ""
    head += f"<style>{style}</style>\n" + (f"<script>{early_script}</script>\n" if early_script else "")
    parts = {
        "policy": f"default-src 'none'; script-src {sources}; style-src {_policy_hash(style)};"
        f" img-src data:{' blob:' if blob_scripts else ''}; base-uri 'none'; form-action 'none'",
        "title": escape(title),
        "head": head,
        "body": body,
        "scripts": "".join(f"<script>{script}</script>\n" for script in scripts),
    }
    return filled(package_text("osm2xodr.viewing", "template/shell.html"), parts).encode("utf-8", "replace")


def filled(template: str, parts: Mapping[str, str]) -> str:
    """Put each part in the place ``@name@`` of a template; places that parts themselves contain stay as they are."""
    return re.sub(r"@([a-z0-9]+)@", lambda match: parts[match.group(1)], template)


def facts(rows: Iterable[tuple[str, str]]) -> str:
    """Return names and values, plain text, as a list of HTML."""
    items = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in rows)
    return f"<dl>{items}</dl>"


def package_text(package: str, path: str) -> str:
    """Return the text of a file that lies in a package."""
    return files(package).joinpath(*path.split("/")).read_text(encoding="utf-8")


def _policy_hash(text: str) -> str:
    """Return the source expression by which a policy allows an inline text."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode('ascii')}'"
