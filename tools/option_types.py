"""Makes the types of options, src/osm2xodr/python_api/keywords.py, of their declarations."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from osm2xodr.conventions import Declaration
from osm2xodr.python_api import DECLARATIONS

TARGET = Path(__file__).parents[1] / "src" / "osm2xodr" / "python_api" / "keywords.py"

_HEAD = '''"""Types of the options of conversions, so that type checkers find misspelt ones.

Made by tools/option_types.py of the declarations on the dataclasses of the stages; a test holds them equal.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Literal, TypedDict
'''
# By the word that stands for the value in --help.
_LISTS = {"LIST": "str | Iterable[str]", "W,S,E,N": "str | Iterable[float]", "TABLE": "str | Mapping[str, float]"}


def module() -> str:
    """Return the module."""
    options = DECLARATIONS.values()
    of_areas = [item for item in options if item.per_area]
    of_all = [item for item in options if not item.per_area]
    parts = [_HEAD, *_keywords("AreaKeywords", "TypedDict", "Options that areas of a batch may have.", of_areas)]
    parts += _keywords(
        "ConvertKeywords", "AreaKeywords", "Options of a conversion; `ConvertOptions` says more.", of_all
    )
    return "".join(parts)


def _keywords(name: str, base: str, text: str, options: list[Declaration]) -> Iterator[str]:
    yield f'\n\nclass {name}({base}, total=False):\n    """{text}"""\n\n'
    yield from (f"    {item.name}: {_type(item)}\n" for item in options)


def _type(item: Declaration) -> str:
    """Return what may be given for an option."""
    found = item.kind.__name__
    if item.choices:
        found = f"Literal[{', '.join(f'{choice!r}' for choice in item.choices)}]".replace("'", '"')
    elif item.kind is Path:
        found = "str | os.PathLike[str]"
    elif item.kind is str:
        found = _LISTS.get(item.metavar or "", found)
    return found if item.default is not None else f"{found} | None"


if __name__ == "__main__":
    TARGET.write_text(module(), encoding="utf-8")
