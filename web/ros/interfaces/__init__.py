"""Contracts as ROS interfaces: messages, services and actions, with their names and values.

Never needs ROS, and never offers anything.
"""
