"""Depth cameras: USB stereo pairs, network streams, folders that another program fills.

Never moves anything.
"""
