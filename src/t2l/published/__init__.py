"""What the study has published: numbers, each with the section that it stands in."""
