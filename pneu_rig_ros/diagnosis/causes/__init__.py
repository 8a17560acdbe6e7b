"""What may be the cause: parameters, conditions, effects and other forms of these."""
