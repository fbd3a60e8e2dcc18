"""The driver of an analyser's desktop program, by keyboard and mouse.

Never clicks what it has not just seen on the screen.
"""
