"""A training simulator fitted to recordings, one set of actuator parameters a gain cell."""
