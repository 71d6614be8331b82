"""An adopted model for other people's simulators.

- `mjcf`: the model as one MJCF; `ranges`: what its uncertainty makes of MuJoCo's parameters
- `folder`: what is written; `robot_files`: of it, `robot`, the Python beside the MJCF, and its data
- `agreement`: the exported robot, run alone, against t2l's prediction
"""
