"""All rules: sentences, readers and limits."""

from __future__ import annotations

from osm2xodr.checking import READERS, RULES


def test_every_rule_says_what_to_do() -> None:
    for rule in RULES.values():
        assert rule.meaning.endswith(".")
        assert rule.remedy.endswith(".")
        assert set(rule.readers) <= set(READERS)
        assert rule.standard or rule.readers
        assert (rule.limit is None) <= ("{value}" not in rule.text)
        if rule.limit is not None and rule.limit.error is not None:
            sign = -1 if rule.limit.least else 1
            assert sign * rule.limit.error >= sign * rule.limit.value
