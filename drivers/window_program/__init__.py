"""Any program that has only a window, operated by mouse and keyboard as a lab's configuration says.

Never clicks what it has not just seen on the screen, and one goal is one pass of its steps.
"""
