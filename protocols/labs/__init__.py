"""The labs that ship with labrun."""
