"""Laws that turn commands into torques."""
