"""Protocols to start from: what `labrun new` writes."""
