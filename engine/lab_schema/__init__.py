"""The JSON Schema of protocols for one lab, for editors: `labrun schema`."""
