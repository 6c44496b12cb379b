"""The points of a step at which effects are asked, in this order (what each is for: ``effects/effect.py``)."""

POINTS = (
    'begin',
    'surroundings',
    'softening',
    'contraction',
    'extra',
    'elasticity',
    'limit',
    'position',
    'resistance',
    'drive',
    'heat',
    'rates',
    'sensor',
    'initial',
    'commit',
)
