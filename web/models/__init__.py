"""Models of the data between page and server; OpenAPI is made from them.

They hold no behaviour.
"""
