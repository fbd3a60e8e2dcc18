"""A protocol in plain English, for the lab book."""
