"""The language, its checks, the tree it becomes, the journal, the runner and the command line.

Never imports `web`; knows devices only by their contracts and through `drivers.client`.
"""
