"""What docs/data keeps of results, as evidence of claims and as tables."""
