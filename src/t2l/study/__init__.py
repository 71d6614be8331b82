"""What belongs to one paper, Bronars, Park and Agrawal, arXiv 2604.02523.

- `published`: its numbers, and grids that a person has downloaded
- `claim`, `evidence`, `words`: a statement is data, and one function from tables and the paper's
  numbers to a `t2l.stats.verdict.Finding`
- `cloning`, `attenuation`, `decoupling`, `landscape`, `identification`, `transfer`, `datasets`,
  `teleoperation`: a topic holds its claims, and what these alone need: model, statistics, figures
- `scoreboard`: the claims of all topics, and how much each says
- `kept`: what docs/data keeps of results, as evidence and as tables

What another study can use stands in `t2l.stats`, `t2l.figures` and below.
"""
