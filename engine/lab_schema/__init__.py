"""The JSON Schema of protocols for one lab, for editors: `labrun schema`.

Does not replace the checker: what a schema cannot express, it accepts.
"""
