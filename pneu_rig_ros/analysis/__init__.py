"""What a record says: friction by Eq. 2, stick-slip cycles, timing. Imports records and scipy."""
