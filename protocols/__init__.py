"""The protocols that ship with labrun."""
