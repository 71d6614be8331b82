"""Figures: from tables and trajectories to PDF and PNG."""
