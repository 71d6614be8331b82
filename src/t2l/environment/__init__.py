"""Closed loops on one batch: of tasks that pay (`environment`), and that are shown (`episodes`)."""
