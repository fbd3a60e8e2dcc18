"""The even form of protocol files, as `labrun fmt` writes it."""
