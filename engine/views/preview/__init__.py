"""The points of a protocol over the work area, before anything moves."""
