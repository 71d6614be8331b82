"""One closed loop on one batch: a task, a robot, an action space, a controller, physics."""
