"""Behaviour cloning: which gains succeed, and whether variants agree."""
