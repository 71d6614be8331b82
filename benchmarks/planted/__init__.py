"""Worlds whose best gains are known by trainings, to judge advice by: `planted_worlds`.

`world` draws a robot with hidden effects, `episode` is an attempt there, `shown` a person who shows
it, `cloned` trains and tries policies under all gains, `verdict` says by the rule what advice is
worth. The machines are the generator's (`benchmarks.hidden_effects`): their physics shares no code
with the library.
"""
