"""What every part asks of Python, the system and the installation: tasks, whole files, signals.

Knows nothing of devices, runs or spectra, and imports no other part of labrun.
"""

import re
import sys

WINDOWS = sys.platform == "win32"
NO_FILE = re.compile(
    r'[<>:"|?*\x00-\x1f]|[ .]$|^(?:con|prn|aux|nul|(?:com|lpt)[0-9¹²³])(?: *\.|$)', re.IGNORECASE
)
"""Names that no file or folder has on Windows: there a device or a hidden stream of another
file, whose content nobody finds again, or nothing.

After Microsoft's "Naming Files, Paths, and Namespaces".
"""
