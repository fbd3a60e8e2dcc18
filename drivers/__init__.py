"""The device server and its client, the drivers, and the simulated twins."""
