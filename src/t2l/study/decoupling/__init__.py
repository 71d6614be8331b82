"""Is the stiffness of a task that of the gains? Policies that hold a pose, and how they yield."""
