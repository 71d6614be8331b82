"""Models fitted to recordings: prediction, initial state, noise, optimisers, uncertainty."""
