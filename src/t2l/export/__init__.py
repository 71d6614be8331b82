"""An adopted model for other people's simulators.

- `mjcf`: the model as one MJCF; `ranges`: what its uncertainty makes of MuJoCo's parameters
- `folder`: what is written, with `robot_template`, the Python beside the MJCF
- `agreement`: the exported robot, run alone, against t2l's prediction
"""
