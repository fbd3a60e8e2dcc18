"""`python -m labrun`: the command line where the `labrun` script is not on the path."""

from labrun.engine.cli import main

main()
