"""The scoreboard: each statement of the study that can be tested, its number, ours, a verdict.

A `Claim` is data and one function from tables to a `t2l.stats.verdict.Finding`. The rules are in
`t2l.stats.verdict`; the study's numbers in `t2l.study.published.numbers`.
"""
