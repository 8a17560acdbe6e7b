"""Residuals of the balances of a run under a hypothesis, their noise, and their significance."""
