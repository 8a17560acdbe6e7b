"""HTML pages and figures of recordings, comparisons, claims and diagnoses."""
