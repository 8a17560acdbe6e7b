"""Analysis of recordings: friction by Eq. 2, regimes, stick-slip cycles, timing."""
