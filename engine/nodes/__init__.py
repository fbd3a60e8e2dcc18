"""The nodes of a run's tree, one kind a file."""
