"""How a run is shown: in a terminal, as plain lines, as lines of JSON.

Never changes the run that it shows.
"""
