"""The device server: its wire, ledger, leases, executions, and the process that hosts it.

Never touches a device for a goal that is not in its ledger.
"""
