"""Word gets out of what no engine can tell: lost devices, engines that are gone, what had to wait.

Never a way into the bench: nothing that comes back is read.
"""
