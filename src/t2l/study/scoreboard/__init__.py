"""Each statement of the study that can be tested, its number, ours, a verdict."""
