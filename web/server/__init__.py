"""The port, the app and the command `labrun web`.

Knows nothing about what a route does.
"""
