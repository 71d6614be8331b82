"""How joints answer their position commands: the gains that hide in commanded and achieved motion.

- what is measured: `lag`, the `frequency_response`, `overshoot` after steps
- what is fitted: a `second_order` system to each `track`, and its `region` of gains
- of what: `motions` of recordings or of a LeRobot data set; `joints` brings it together
"""
