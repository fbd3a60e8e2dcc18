"""What a person sees in a browser: the page, its server, the report, and the faces for ROS.

Never talks to a device but through `drivers.client`.
"""
