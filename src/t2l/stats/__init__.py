"""Statistics: from one row per rollout to the numbers of a table."""
