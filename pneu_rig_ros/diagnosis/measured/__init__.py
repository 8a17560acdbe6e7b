"""A measured run as the diagnosis takes it, and the model that is held against it."""
