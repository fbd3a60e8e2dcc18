"""The devices of the bench by hand: links, actions, arming, jogging, the stop."""
