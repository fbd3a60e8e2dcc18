"""A gantry behind Marlin on a serial port, such as a converted 3D printer.

Never gives it more of its way than it can brake within: Marlin knows no feed hold.
"""
