"""Whatever a file or a command line holds: it runs, or ends with one message, and harms nothing."""
