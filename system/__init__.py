"""What every part asks of Python and the system: tasks, whole files, processes, signals, terminals.

Knows nothing of devices, runs or spectra, and imports no other part of labrun.
"""

import sys

WINDOWS = sys.platform == "win32"
