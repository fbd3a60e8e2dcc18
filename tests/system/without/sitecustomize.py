"""For tests: Python as it is where the libraries in LABRUN_TEST_WITHOUT are not installed."""

import os
import sys


class Without:
    """Stands before all finders, and finds nothing of these libraries."""

    def __init__(self, libraries):
        self.libraries = libraries

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in self.libraries:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


sys.meta_path.insert(0, Without(os.environ["LABRUN_TEST_WITHOUT"].split()))
