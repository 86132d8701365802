"""What walking means: task, parameters, motion, constraints and the result."""
