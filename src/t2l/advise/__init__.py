"""Which gains suit a robot, before anything is trained: its loop, its demonstrations, learning."""
