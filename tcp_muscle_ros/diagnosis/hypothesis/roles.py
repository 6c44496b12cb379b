"""The effects that are fitted in a way of their own, found by what each says of itself; '' where there is none."""

from collections.abc import Callable

from tcp_muscle_ros.muscle import EFFECTS, Effect


def _the_one(says: Callable[[Effect], bool]) -> str:
    return next((name for name, effect in EFFECTS.items() if says(effect)), '')


SWINGS = _the_one(lambda effect: effect.swings)  # after it a weight swings
COURSE = _the_one(lambda effect: effect.latent == 'course')  # how it went in time is inferred
SLIPS = _the_one(lambda effect: effect.latent == 'slips')  # it is the mean of sudden slips
STICKS = _the_one(lambda effect: effect.sticks)
CHANCE = _the_one(lambda effect: effect.chance)  # it rests and jumps at instants of chance
LIKE_SLIPS = tuple(name for name, effect in EFFECTS.items() if effect.like_slips)
