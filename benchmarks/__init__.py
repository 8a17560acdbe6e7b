"""Every figure of docs/benchmarks.md: ``make bench``."""
