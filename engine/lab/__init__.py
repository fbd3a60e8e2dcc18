"""Devices of a lab, and which of them plays which role of a protocol.

Never connects to a device.
"""
