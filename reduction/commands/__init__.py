"""Commands of the reduction: registered as `labrun.commands`, one function a file."""
