"""The paper's statements as experiments: run, measured, compared."""
