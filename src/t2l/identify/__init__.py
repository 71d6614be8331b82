"""Models fitted to recordings: one engine for a robot's missing effects and the study's actuators.

- what is predicted: `prediction`, of `samples`, by `schedules` that `batches` of `simulation` run;
  from an `initial_state`, in steps of a `step_size`
- what limits it: `noise_floor`, `uncertainty`, `block_bootstrap`
- what is fitted: a `model` of effects; `actuator_parameters` of
  `t2l.sim.training_simulator`
- how: an `optimiser`, by `least_squares` or `cma_es`; `fitting` and `rough` run them on
  predictions, `actuators` on the training simulator
"""
