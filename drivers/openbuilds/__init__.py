"""A gantry behind the program OpenBuilds CONTROL.

Never takes the program's Idle as proof that a line was carried out.
"""
