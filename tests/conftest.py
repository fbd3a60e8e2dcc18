"""Fixed seeds everywhere: Hypothesis draws the same examples in every run of the suite.

`pytest --hypothesis-profile=explore` draws new ones, to look for what nobody has thought of yet.
"""

from hypothesis import settings

settings.register_profile("fixed", derandomize=True, deadline=None)
settings.register_profile("explore", derandomize=False, deadline=None, max_examples=1000)
settings.load_profile("fixed")
