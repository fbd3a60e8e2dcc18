"""All runs of a folder, to find one again and to compare some: made from what each says of itself.

Never the truth: whatever is here can be deleted, and is made again.
"""
