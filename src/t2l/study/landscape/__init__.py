"""How easily reinforcement learning finds policies, at the corners of the grid."""
