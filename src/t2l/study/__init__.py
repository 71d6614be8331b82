"""What belongs to one paper, Bronars, Park and Agrawal, arXiv 2604.02523."""
