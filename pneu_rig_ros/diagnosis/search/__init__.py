"""Which cause it is: screening, fits, selection, and a description where none is."""
