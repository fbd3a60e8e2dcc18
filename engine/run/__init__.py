"""What one run is: its frame of names, folder, files, rows, clock and questions.

Never ticks the tree or talks to a device.
"""
