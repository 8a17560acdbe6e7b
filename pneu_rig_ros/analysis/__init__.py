"""What a recording says: friction by Eq. 2, regimes, stick-slip cycles, timing."""
