"""Sort the points of a map into classes, and say what each may be."""
