"""A gantry behind GRBL 1.1 or grblHAL on a serial port.

Never sends a move before it knows where the machine is.
"""
