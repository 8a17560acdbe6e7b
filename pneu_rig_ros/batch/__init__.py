"""Many plants at once, on all processors, with the bits of each run alone."""
