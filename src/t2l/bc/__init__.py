"""Behaviour cloning: training a policy on a cell's data set and rolling it out in that cell."""
