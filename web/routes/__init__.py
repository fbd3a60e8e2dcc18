"""The routes of the API, one file per family.

They only translate between HTTP and the rest.
"""
