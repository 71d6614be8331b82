"""A policy on the robot and in its simulator, from the same starts to the same goals."""
