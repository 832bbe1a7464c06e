"""Makes docs/diagnostics.md of what the code knows about the codes of diagnostics: ``tools/diagnostics_table.py``."""

from __future__ import annotations

from pathlib import Path

from osm2xodr.reporting import Code, codes

TARGET = Path(__file__).parents[1] / "docs" / "diagnostics.md"

_HEAD = """\
# Diagnostics

What `osm2xodr convert` guesses, drops or repairs, and what else there is to know, it reports as diagnostics:
`--report-json` lists each with its OSM id, `-v` how often each was found, `-vv` all of them. `osm2xodr explain CODE`
prints a row of this table, and explains rules of `osm2xodr check` as well ([check.md](check.md)). Corrections
([corrections.md](corrections.md)) say what OSM does not, and `--osm-issues` lists its mistakes.

Codes are stable names. The summary at the end of a conversion lists those of the first table, in this order; the
findings of `--check` stand after `clearance`.

<!-- Made by tools/diagnostics_table.py of src/osm2xodr/reporting/codes.ini; a test holds them equal. -->
"""


def page() -> str:
    """Return the document."""
    known = codes()
    urgent = sorted((item.harm, name) for name, item in known.items() if item.harm is not None)
    rest = sorted(name for name, item in known.items() if item.harm is None)
    parts = [_HEAD]
    for title, names in (("Needs attention", [name for _, name in urgent]), ("All others", rest)):
        rows = "\n".join(_row(name, known[name]) for name in names)
        parts.append(f"## {title}\n\n| code | kind | what was found | what to do |\n|---|---|---|---|\n{rows}\n")
    return "\n".join(parts)


def _row(name: str, item: Code) -> str:
    kinds = ", ".join(kind.value for kind in item.kinds)
    mark = " Listed by `--osm-issues`" + (
        "." if set(item.osm) == set(item.kinds) else f" where {' or '.join(kind.value for kind in item.osm)}."
    )
    line = f" Correction: `{item.correction}`." if item.correction else ""
    cells = (f"`{name}`", kinds, item.meaning, item.remedy + line + (mark if item.osm else ""))
    return "| " + " | ".join(cell.replace("|", "\\|").replace("<", "&lt;") for cell in cells) + " |"


if __name__ == "__main__":
    TARGET.write_text(page(), encoding="utf-8")
