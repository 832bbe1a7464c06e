"""Whatever is wrong with a file, checking it ends with findings and not with an exception."""

from __future__ import annotations

import copy
import random
from pathlib import Path

import pytest
from lxml import etree
from t_junction import Tree, sound_tree

from osm2xodr.checking import FORMATS, READERS, CheckOptions, Severity, check_file
from osm2xodr.errors import InputError

VALUES = ("nan", "-1", "0", "1e300", "inf", "x", "", "-7", "999999999999", "3", "1e-9", "end", "road", "junction")
CHANGES = 12


def damage(tree: Tree, dice: random.Random) -> None:
    """Remove, repeat and change elements and attributes at random."""
    elements = list(tree.iter("*"))[1:]
    for _ in range(CHANGES):
        element = dice.choice(elements)
        parent = element.getparent()
        what = dice.random()
        if what < 0.2 and parent is not None:
            parent.remove(element)
        elif what < 0.3 and parent is not None:
            parent.append(copy.deepcopy(element))
        elif element.attrib:
            name = dice.choice(sorted(str(key) for key in element.attrib))
            if what < 0.5:
                del element.attrib[name]
            else:
                element.set(name, dice.choice(VALUES))


@pytest.mark.parametrize("seed", range(60))
def test_it_is_reported(seed: int, tmp_path: Path) -> None:
    tree = sound_tree()
    damage(tree, random.Random(seed))
    path = tmp_path / "damaged.xodr"
    path.write_bytes(etree.tostring(tree))
    try:
        result = check_file(path, CheckOptions(readers=READERS, ignore=("schema",)))
    except InputError as error:
        # Lanes of kilometres are refused as a whole: too much would have to be compared.
        assert "a sound file can have" in str(error)  # noqa: PT017 - most damage can be read
        return
    assert result.failed(Severity.WARNING)
    for write in FORMATS.values():
        assert len(write([result], Severity.WARNING)) > 100
