"""Where a model departs from recordings, and which physical effect it lacks."""
