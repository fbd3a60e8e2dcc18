"""What this server has on its own machine: durable files, workers, clocks, device servers.

Knows nothing about routes.
"""
