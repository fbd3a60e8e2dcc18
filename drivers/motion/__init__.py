"""What every gantry shares, whatever carries its commands: boxes to keep out of, outputs, ways.

Never talks to a controller.
"""
