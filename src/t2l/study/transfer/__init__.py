"""Transfer from simulation to a robot: the rule that was registered, and what comes of it."""
