"""Says whether everything is ready for the release of a tag: ``tools/release.py v0.2.0``; exit status 1 if not."""

from __future__ import annotations

import re
import sys
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[1]


def faults(tag: str, root: Path = ROOT) -> list[str]:
    """Return what is not ready yet."""
    texts = {name: (root / name).read_text(encoding="utf-8") for name in ("CHANGELOG.md", "CITATION.cff")}
    found = re.search(r'^__version__ = "(.+)"', (root / "src/osm2xodr/__init__.py").read_text("utf-8"), re.M)
    version = found[1] if found else ""
    heading = re.search(rf"^## {re.escape(version)} - (\d{{4}}-\d\d-\d\d)$", texts["CHANGELOG.md"], re.M)
    cited = re.search(r'^version: (.+)\ndate-released: "(.+)"$', texts["CITATION.cff"], re.M)
    hooks = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["tool"]["hatch"]["metadata"]["hooks"][
        "custom"
    ]
    out = []
    if tag != f"v{version}":
        out.append(f"the tag is {tag}, but src/osm2xodr/__init__.py has the version {version}")
    if heading is None:
        out.append(f"CHANGELOG.md has no heading '## {version} - YEAR-MONTH-DAY'")
    elif cited is None or cited.groups() != (version, heading[1]):
        out.append(f"CITATION.cff does not have the version {version} of {heading[1]}, as CHANGELOG.md does")
    out += [f"pyproject.toml has no {name} of the project yet" for name, url in hooks.items() if "example" in url]
    return out


if __name__ == "__main__":
    wrong = faults(sys.argv[1])
    print("\n".join(wrong) or "ready", file=sys.stderr if wrong else sys.stdout)
    sys.exit(bool(wrong))
