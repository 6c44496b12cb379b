"""The truth generator: a muscle written from the physics document alone, in other forms than any catalogue."""

# they enter their effects, those called outside a fourth form of each
from proof.truth import (  # noqa: F401
    electrical,
    instruments,
    mechanical,
    outside,
    outside_bench,
    outside_heat,
    thermal,
    unlisted,
)
from proof.truth.bench import Bench, Experiment, Signals, observe
from proof.truth.body import Body, draw_body
from proof.truth.concealed import EFFECTS, Concealed, conceal

__all__ = ['EFFECTS', 'Bench', 'Body', 'Concealed', 'Experiment', 'Signals', 'conceal', 'draw_body', 'observe']
