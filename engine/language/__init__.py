"""The protocol language: YAML with its places, expressions with types and units, arguments.

Never knows a device, only what contracts say.
"""
