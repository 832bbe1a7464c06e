"""A reader that is missing or crashes is a failure that says so, and never a test left out."""

from __future__ import annotations

import sys

import pytest
from real_readers import need, run_reader


def test_a_missing_reader_fails_with_the_remedy() -> None:
    with pytest.raises(pytest.fail.Exception, match=r"The Reader is not installed.*pip install -e '\.\[test\]'"):
        need("no_such_reader", "The Reader")


def test_an_installed_reader_is_fine() -> None:
    need("lxml", "lxml")
    assert run_reader([sys.executable, "-c", "print('read')"]).stdout == "read\n"


def test_a_crash_is_named() -> None:
    crash = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"
    with pytest.raises(pytest.fail.Exception, match="crashes with SIGSEGV"):
        run_reader([sys.executable, "-c", crash])
