"""How gains attenuate errors of actions: theory, simulation, and what follows for success."""
