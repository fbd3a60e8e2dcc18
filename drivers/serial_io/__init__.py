"""Lines of text over a serial port, off the event loop.

Never shares a port with another program.
"""
