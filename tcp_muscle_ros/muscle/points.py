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
# An effect at none of these leaves the paper's heat balance as it is, and its exact solution holds.
HEATING_POINTS = frozenset({'surroundings', 'resistance', 'drive', 'heat', 'rates'})
