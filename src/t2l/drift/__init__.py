"""Has the machine drifted since its model was made: each adopted effect fitted to a new log."""
