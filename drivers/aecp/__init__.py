"""The driver of the paper's own analyser server."""
