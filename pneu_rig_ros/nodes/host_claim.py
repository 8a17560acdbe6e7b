"""
A name that only one process of this computer holds at a time.

It is the address of a socket in Linux's abstract namespace (unix(7)): no file is left behind, the
kernel frees it however its process ends, and containers with a network of their own, which DDS
does not reach either, do not share it.
"""

import errno
import hashlib
import socket
import sys

PREFIX = '\0pneu_rig_ros/'


class HostClaim:
    """
    Claims a name for as long as it lives.

    :param name: of any length
    """

    def __init__(self, name: str) -> None:
        self._address = PREFIX + hashlib.sha256(name.encode()).hexdigest()
        self._socket: socket.socket | None = None

    def held_elsewhere(self) -> bool:
        """Return whether another has the name; if not, it is this one's. Never so but on Linux."""
        if self._socket is not None or sys.platform != 'linux':
            return False
        attempt = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            attempt.bind(self._address)
        except OSError as error:
            attempt.close()
            return error.errno == errno.EADDRINUSE
        self._socket = attempt
        return False

    def release(self) -> None:
        """Let others have it."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None
