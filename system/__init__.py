"""What every part asks of Python, the system and the installation: tasks, whole files, signals.

Knows nothing of devices, runs or spectra, and imports no other part of labrun.
"""

import sys

WINDOWS = sys.platform == "win32"
