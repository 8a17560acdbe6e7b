"""``python -m reliability.burner``: keeps one core busy for a third of the time, until killed."""

import time

BUSY, IDLE = 5.0, 10.0
"""Seconds of work, and of rest after it."""


def main() -> None:
    """Alternate between work and rest."""
    while True:
        end = time.monotonic() + BUSY
        while time.monotonic() < end:
            pass
        time.sleep(IDLE)


if __name__ == '__main__':
    main()
