"""The commands of `labrun`, one a file."""
