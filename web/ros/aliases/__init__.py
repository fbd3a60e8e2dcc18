"""Names in the lab's `ros: aliases:`: the paper's own with its types, or any other for one action.

Never reach a shell: `/launch` starts only what the lab registers.
"""
