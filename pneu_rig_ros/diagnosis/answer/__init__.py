"""
What the answer states beside the cause: intervals, alternatives, closed gap, next experiment.

How recordings differ from each other is the subject of three modules: ``run_differences`` tests
whether one recording differs from the others, ``random_effects`` estimates by how much a quantity
varies between all of them, and ``repeatability`` keeps both in the improved model. What differs
and explains nothing, such as a clock offset, is in ``residuals.nuisances``;
``residuals.replicates`` are recordings simulated with a model.
"""
