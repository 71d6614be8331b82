"""What the study has published beside its paper, read from files that a person has downloaded."""
