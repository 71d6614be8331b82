"""What belongs to one paper, Bronars, Park and Agrawal, arXiv 2604.02523.

A statement of it is a `claim.Claim`: data, and one function from tables (`evidence`) and its own
numbers (`published`) to a `t2l.stats.verdict.Finding`. A topic holds its claims, and beside them
what only these need: model, statistics, figures. `scoreboard` puts the claims of all together.
"""
