"""Signals that end the process, deferred where something has to be finished first."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator
from types import FrameType

from osm2xodr.system.limits import ENDING_SIGNALS


@contextlib.contextmanager
def uninterrupted() -> Iterator[None]:
    """Defer the signals that end the process to the end of the block.

    SIGINT is blocked, also for threads and processes that are started meanwhile, and for those that they start:
    Ctrl-C at the terminal reaches this process alone, which then stops its workers in order. Where the system blocks
    no signals, it is deferred as the others.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    deferred: list[int] = []

    def defer(number: int, frame: FrameType | None) -> None:
        deferred.append(number)

    can_block = hasattr(signal, "pthread_sigmask")
    numbers = ENDING_SIGNALS if can_block else (signal.SIGINT, *ENDING_SIGNALS)
    before = {number: signal.getsignal(number) for number in numbers}
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, defer)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if can_block else set()
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for late in deferred[:1]:
            signal.raise_signal(late)
        if can_block:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
