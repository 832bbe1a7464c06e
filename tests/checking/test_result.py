"""What can be asked of a check."""

from __future__ import annotations

import pytest

from osm2xodr.checking import CheckOptions


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"readers": ("carl",)}, "carl is no reader"),
        ({"only": ("gap",)}, "gap is no rule"),
        ({"ignore": ("gap",)}, "gap is no rule"),
        ({"most": -1}, "-1 findings"),
    ],
)
def test_what_is_unknown_is_refused(options: dict[str, object], text: str) -> None:
    with pytest.raises(ValueError, match=text):
        CheckOptions(**options)  # type: ignore[arg-type]
