"""The missing-effect workflow: where a model and measured data disagree, and why."""
