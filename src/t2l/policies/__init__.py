"""Policies: networks from observations to commands, and their files."""
