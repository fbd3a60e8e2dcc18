"""Manual operation of the devices: links, actions, arming, jogging, the stop.

Never moves anything after the request for it has ended.
"""
