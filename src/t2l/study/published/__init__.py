"""What the study has published: its printed numbers, and grids that a person has downloaded."""
