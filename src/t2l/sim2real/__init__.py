"""The robot at the other end: deployed on, measured, compared with its simulator."""
