"""A damaged T junction, checked."""

from __future__ import annotations

from pathlib import Path

from lxml import etree
from t_junction import Tree

from osm2xodr.checking import CheckOptions, CheckResult, check_file


def checked(tree: Tree, path: Path, **options: object) -> CheckResult:
    """Write a file and check it, by default without its schema."""
    path.write_bytes(etree.tostring(tree))
    return check_file(path, CheckOptions(**{"ignore": ("schema",), **options}))  # type: ignore[arg-type]
