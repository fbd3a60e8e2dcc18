"""The tree of a protocol as the text of a drawing: Mermaid or DOT.

Never draws: Mermaid and Graphviz do.
"""
