"""What every test shares."""

from tcp_muscle_ros.threads import one_of_linear_algebra

one_of_linear_algebra()  # before numpy comes

from hypothesis import settings  # noqa: E402

# A property is about values; how long one takes depends on what numba still has to compile and on who else computes.
settings.register_profile('untimed', deadline=None)
settings.load_profile('untimed')
