"""Optimal experimental design: motions that tell effects apart, and what a log cannot tell.

- `library`: the motions to choose from; `safety` keeps them within the robot's limits
- `sensitivity`: what each parameter of each effect changes in the measured positions
- `spans`, `collinearity`: which effects can do what another one does
- `d_optimal`: the choice;  `identifiability`: what the chosen motions, or a log, will tell
"""
