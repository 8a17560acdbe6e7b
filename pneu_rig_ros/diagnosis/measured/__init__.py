"""A measured run as the diagnosis uses it, and the hypothesis that is compared with it."""
