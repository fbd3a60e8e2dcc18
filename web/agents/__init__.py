"""`labrun mcp`: what the page does with protocols and runs, as tools for agents (Model Context Protocol).

Never arms, confirms, answers or releases anything: that is for people.
"""
