"""The one error that a user of the rig can cause and can mend."""


class RigError(Exception):
    """
    Bad input or a missing prerequisite, told in one line: what, where, allowed.

    The command line prints it and ends with exit code 2; nodes log it and stop.
    """
