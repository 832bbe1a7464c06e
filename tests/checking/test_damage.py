"""Each kind of damage that is known to break readers is made from a sound file, and named."""

from __future__ import annotations

from pathlib import Path

import pytest
from lxml import etree
from map_damage import DAMAGES, Damage
from t_junction import sound_map, sound_tree

from osm2xodr.checking import READERS, RULES, CheckOptions, Severity, check_file

EVERYONE = CheckOptions(readers=READERS)
# Kinds of damage that were tried in readers of OpenDRIVE.
TRIED = 103


def test_the_sound_file_is_clean(tmp_path: Path) -> None:
    path = tmp_path / "sound.xodr"
    path.write_text(sound_map(), encoding="utf-8")
    result = check_file(path, EVERYONE)
    assert result.findings == ()
    assert result.counts == ()
    assert result.notes == ()
    assert result.size[:2] == (10, 1)
    assert result.size[2] == pytest.approx((190 + 40 + 4 * 5 * 3.14159265) / 1000, abs=1e-5)


def test_all_kinds_that_were_tried_are_here() -> None:
    assert len(DAMAGES) >= TRIED
    assert len({item.name for item in DAMAGES}) == len(DAMAGES)
    assert {item.rule for item in DAMAGES} - {""} <= set(RULES)


@pytest.mark.parametrize("item", DAMAGES, ids=lambda item: item.name)
def test_damage_is_named(item: Damage, tmp_path: Path) -> None:
    tree = sound_tree()
    item.change(tree)
    path = tmp_path / "damaged.xodr"
    path.write_bytes(etree.tostring(tree))
    result = check_file(path, EVERYONE)
    if item.rule:
        assert item.rule in result.by_rule()
        listed = [finding for finding in result.findings if finding.rule == item.rule]
        assert listed
        assert all("{" not in finding.text and finding.text for finding in listed)
        # The finding is there for each affected reader alone, too.
        for reader in RULES[item.rule].readers:
            assert item.rule in check_file(path, CheckOptions(readers=(reader,), only=(item.rule,))).by_rule()
    else:
        assert [found for found in result.counts if found.severity > Severity.INFO] == []


def test_every_rule_is_broken_by_some_damage() -> None:
    # What needs a road network or cannot be told from something else is tried elsewhere.
    elsewhere = {"side-lane-gap", "version-unread"}
    assert set(RULES) - {item.rule for item in DAMAGES} == elsewhere
