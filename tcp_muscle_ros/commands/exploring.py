"""What an investigation records before its first diagnosis, and to see whether an answer stands; and the run that it
keeps back.

A diagnosis names only what its recordings can show. So the first protocols show each of what the catalogue's effects
depend on: three temperatures, a long hold, reversals inside a loop, fast switching, other loads, steps of the load. The
further ones ask the same in another way: what is named wrongly, or not seen, under one load and pace differs at others.
What comes with the number of cycles shows beside a stronger effect only where there are many.
"""

from collections.abc import Sequence
from typing import NamedTuple

from tcp_muscle_ros.recording.protocol import Protocol, Ramp, Segment

RATE = 20.0  # Hz
_PROBE = 0.05  # of the largest current: enough for the resistance, too little to heat
_ABOUT = (0.25, 0.5, 1.0, 2.0)  # times the usual load: under the least, coils that touch show
_SWITCHES = (4, 2, 9, 6, 2, 4, 14, 6, 9, 2, 2, 4, 6, 14, 9, 4, 2, 6, 9, 4)  # s, on and off by turns
_LEVELS = (1.0, 0.65, 0.85)  # of the largest current, by turns

_Share = float | tuple[float, float]  # of the largest current; or from one to another
_Steps = Sequence[tuple[float, _Share]]  # s each

_HEATINGS: _Steps = ((5.0, 0.0), (25.0, 1.0), (45.0, 0.0), (25.0, 0.8), (45.0, 0.0), (25.0, 0.65), (45.0, 0.0))
_HOLD: _Steps = ((8.0, _PROBE), (150.0, 0.9), (70.0, _PROBE))
_STAIRS = (0.45, 0.7, 0.85, 1.0, 0.85, 0.7, 0.55, 0.75, 0.9, 0.75, 0.55, 0.8, 1.0, 0.7, 0.45)
_RAMPS: _Steps = ((5.0, 0.0), *((s, way) for s in (20.0, 50.0) for way in ((0.35, 1.0), (1.0, 0.35))), (45.0, _PROBE))
_GENTLE_HOLD: _Steps = ((30.0, _PROBE), (110.0, 0.75), (110.0, _PROBE))
_CYCLES: _Steps = ((5.0, 0.0), *((20.0, 1.0), (30.0, 0.0)) * 6)
_WEARING: _Steps = ((5.0, 0.0), *((11.0, 1.0), (13.0, 0.0)) * 30)  # more cycles than all others have
_FALLING: _Steps = ((5.0, 0.0), *((16.0, share) for share in (1.0, 0.8, 0.6, 0.4, 0.7, 0.5, 0.9, 0.6)), (45.0, 0.0))
_KEPT_BACK: _Steps = ((5.0, 0.0), (12.0, 0.9), (8.0, 0.5), (20.0, 0.0), (20.0, 0.7), (10.0, 1.0), (45.0, 0.0))


class _Step(NamedTuple):
    seconds: float
    share: _Share
    load: float  # N


def loads_about(load: float, available: Sequence[float]) -> tuple[float, ...]:
    """The loads (N) of an exploration, lightest first: those that there are, or a quarter to twice the usual one."""
    usable = [one for one in available if one <= max(_ABOUT) * load]
    return tuple(sorted(usable or (round(share * load, 4) for share in _ABOUT)))


def first_protocols(current: float, loads: Sequence[float], load: float, ambient: float) -> list[Protocol]:
    """What is recorded first.

    Args:
        current: the largest, A.
        loads: that the rig can change to by itself, N; with one alone nothing is done to the load.
        load: the usual one, N.
        ambient: K.
    """
    levels = [0.0 if k % 2 else _LEVELS[k // 2 % len(_LEVELS)] for k in range(len(_SWITCHES))]
    switching = [(float(seconds), share) for seconds, share in zip(_SWITCHES, levels, strict=True)]
    stairs = [(5.0, 0.0), *((14.0, share) for share in _STAIRS), (40.0, 0.0)]
    made = [
        *(_under(load, steps, current, ambient) for steps in (_HEATINGS, stairs, _HOLD)),
        _under(loads[0], [*switching, (40.0, _PROBE)], current, ambient),
    ]
    if len(loads) > 1:
        made += [_made(steps, current, ambient) for steps in (_each_heated(loads), _load_steps(loads))]
    return made


def further_protocols(current: float, loads: Sequence[float], load: float, ambient: float) -> list[list[Protocol]]:
    """What is recorded once there is an answer, to see whether it stands: one round, and another where it did not.

    Args and units as of ``first_protocols``.
    """
    heavy, light, beside = loads[-1], loads[0], loads[(len(loads) - 1) // 2]
    once = ((load, _WEARING), (heavy, _HEATINGS), (light, _RAMPS), (beside, _GENTLE_HOLD))
    again = ((light, _CYCLES), (heavy, _FALLING), (light, _HOLD))
    return [[_under(force, steps, current, ambient) for force, steps in one] for one in (once, again)]


def kept_back_protocol(current: float, load: float, ambient: float) -> Protocol:
    """What is recorded last and shown to no diagnosis."""
    return _under(load, _KEPT_BACK, current, ambient)


def _each_heated(loads: Sequence[float]) -> list[_Step]:
    return [_Step(5.0, 0.0, loads[0]), *(s for f in loads for s in (_Step(30.0, 1.0, f), _Step(40.0, 0.0, f)))]


def _load_steps(loads: Sequence[float]) -> list[_Step]:
    """Up and down again, cold and hot."""
    there_and_back = [*loads, *reversed(loads[:-1])]
    cold = [_Step(9.0, _PROBE, f) for f in there_and_back]
    hot = [_Step(40.0, 0.85, loads[0]), *(_Step(9.0, 0.85, f) for f in there_and_back[1:])]
    return [*cold, *hot, _Step(45.0, _PROBE, loads[0])]


def _under(load: float, steps: _Steps, current: float, ambient: float) -> Protocol:
    return _made([_Step(seconds, share, load) for seconds, share in steps], current, ambient)


def _made(steps: Sequence[_Step], current: float, ambient: float) -> Protocol:
    segments = tuple(Segment(step.seconds, _of(current, step.share), Ramp(step.load, step.load)) for step in steps)
    return Protocol(RATE, 'current', segments, load=steps[0].load, ambient=ambient)


def _of(current: float, share: _Share) -> Ramp:
    start, end = share if isinstance(share, tuple) else (share, share)
    return Ramp(start * current, end * current)
