"""Settings that hold for all tests, and fixtures that several folders share."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from typing import TYPE_CHECKING

import hatch_build
import pytest
from hypothesis import settings
from real_readers import ALL_READERS
from scene_files import Conversions

if TYPE_CHECKING:
    from browser import Page

# The same examples in every run, and no failures because a machine is slow.
settings.register_profile("gate", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("gate")

# Shells let what they start in the background ignore Ctrl-C, and so would all that tests start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Where readers of OpenDRIVE have no packages, what needs them is left out; elsewhere nothing may be, not even a skip.
NEED_READERS = ["readers", "xodrWriter/test_schema.py", "checking/checks/test_schema.py", "checking/test_damage.py"]
collect_ignore = [] if ALL_READERS else NEED_READERS


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the flag that renews records."""
    parser.addoption("--update-golden", action="store_true", help="write the records in tests/golden anew")


def pytest_sessionstart() -> None:
    """Test the compiled form of what stands here, not of what stood here before."""
    old = [module.name for module in hatch_build.modules() if not hatch_build.up_to_date(module)]
    there = any(hatch_build.compiled(module).exists() for module in hatch_build.modules())
    if old and (there or hatch_build.has_compiler()):
        pytest.exit(f"{', '.join(old)}: changed after compilation; run: make .venv/.test", returncode=1)


def pytest_report_header() -> list[str]:
    """Say what is left out."""
    readers = "all" if ALL_READERS else "LEFT OUT, some have no packages for this Python or system (use 3.10 to 3.12)"
    loops = "compiled" if hatch_build.has_compiler() else "run as Python: no C compiler, or no headers of Python"
    return [f"readers of OpenDRIVE: {readers}", f"loops: {loops}"]


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Fail the gate where a test was skipped that could have run."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is not None and ALL_READERS and exitstatus == 0 and reporter.stats.get("skipped"):
        reporter.write_line("skipped tests prove nothing: the gate fails", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.fixture(scope="session")
def conversions(tmp_path_factory: pytest.TempPathFactory) -> Conversions:
    """Scenes as the command line converts them, each only once."""
    base = tmp_path_factory.getbasetemp()
    # pytest-xdist gives each of its workers a folder of its own within that of the session.
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "conversions"
    folder.mkdir(exist_ok=True)
    return Conversions(folder)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """A page in a real browser, which the tests of a module share."""
    # Most tests need none.
    from browser import browser

    with browser(tmp_path_factory.mktemp("profile")) as found:
        yield found
