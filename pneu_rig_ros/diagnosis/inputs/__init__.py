"""What goes in: the file of a system, its recordings, what of them is not as stated."""
