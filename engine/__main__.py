"""`python -m labrun.engine`: the command line where the `labrun` script is not on the path."""

from .cli import main

main()
