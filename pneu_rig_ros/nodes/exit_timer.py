"""
The end of a process whose nodes cannot be destroyed.

Fast DDS 2.14 may wait for itself forever, at full load, when a participant is destroyed while it
learns that another one has ended: `DomainParticipant::set_listener` holds the mutex for which the
callback waits that it waits for. Of nodes that get Ctrl-C together this is one in some 30. rclpy
holds the interpreter lock meanwhile, so that no Python code can end the process: a timer of the
operating system does (timer_create(2)).
"""

import ctypes
import sys
import time

SIGEV_THREAD = 2
"""A timer that calls a function, see sigevent(7)."""


class _Event(ctypes.Structure):
    """`struct sigevent` of Linux: the function that is called, and its argument."""

    _fields_ = (
        ('value', ctypes.c_void_p),
        ('signal', ctypes.c_int),
        ('notify', ctypes.c_int),
        ('function', ctypes.c_void_p),
        ('unused', ctypes.c_byte * 40),
    )


def exit_after(seconds: int, code: int) -> None:
    """End this process after some time, whatever it does then; does nothing but on Linux."""
    if sys.platform != 'linux':
        return
    libc = ctypes.CDLL(None)
    function = ctypes.cast(libc._exit, ctypes.c_void_p)
    event = _Event(value=code, notify=SIGEV_THREAD, function=function)
    timer, delay = ctypes.c_void_p(), (ctypes.c_long * 4)(0, 0, seconds, 0)
    libc.timer_create(time.CLOCK_MONOTONIC, ctypes.byref(event), ctypes.byref(timer))
    libc.timer_settime(timer, 0, delay, None)
