"""What every test shares."""

from hypothesis import settings

# A property is about values; how long one takes depends on what numba still has to compile and on who else computes.
settings.register_profile('untimed', deadline=None)
settings.load_profile('untimed')
