"""docs/check.md lists the rules as they are."""

from __future__ import annotations

from pathlib import Path

from osm2xodr.checking import DEFAULT_READERS, READERS, RULES, Rule
from osm2xodr.checking.findings import quantity

TEXT = (Path(__file__).parents[2] / "docs" / "check.md").read_text(encoding="utf-8")


def row(rule: Rule) -> str:
    """Return a rule's row of the table."""
    severity, limit = rule.severity.word, ""
    if rule.limit is not None:
        limit = quantity(rule.limit.value, rule.unit) + (f" ({rule.limit.source})" if rule.limit.source else "")
        if rule.limit.error == rule.limit.value:
            severity = "error"
        elif rule.limit.error is not None:
            side = "below" if rule.limit.least else "from"
            severity += f", error {side} {quantity(rule.limit.error, rule.unit)}"
    who = ", ".join(rule.readers)
    impact = f"{who}: {rule.impact}" if who else rule.impact
    origin = "standard" if rule.standard else "readers"
    cells = (f"`{rule.name}`", severity, rule.meaning, limit, origin, impact, rule.remedy)
    return "| " + " | ".join(cell.replace("|", "\\|").replace("<", "&lt;") for cell in cells) + " |"


def test_every_rule_is_listed_as_it_is() -> None:
    listed = [line for line in TEXT.splitlines() if line.startswith("| `")]
    assert listed == [row(rule) for rule in RULES.values()]


def test_readers_are_named() -> None:
    assert f"`--for` {', '.join(READERS)}" in TEXT
    assert f"default {', '.join(DEFAULT_READERS)}" in TEXT
