drives: u
shape: !!timestamp x
