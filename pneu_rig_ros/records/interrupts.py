"""Interrupts that wait until what is written is whole."""

import contextlib
import signal
import threading
from collections.abc import Iterator


@contextlib.contextmanager
def deferred_interrupts() -> Iterator[None]:
    """Let SIGINT and SIGTERM wait; their handlers, those of Python, run at the end."""
    if threading.current_thread() is not threading.main_thread():
        yield  # Python runs handlers in the main thread alone
        return
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    pending: list[int] = []
    ours = [number for number, handler in handlers.items() if callable(handler)]
    for number in ours:
        signal.signal(number, lambda received, _: pending.append(received))
    try:
        yield
    finally:
        for number in ours:
            signal.signal(number, handlers[number])
        if pending:
            signal.raise_signal(pending[0])
