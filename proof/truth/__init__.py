"""The truth generator: a muscle written from the physics document alone, in other forms than any catalogue."""

from proof.truth import electrical, instruments, mechanical, thermal, unlisted  # noqa: F401 (they enter their effects)
from proof.truth.bench import Bench, Experiment, Signals, observe
from proof.truth.body import Body, draw_body
from proof.truth.concealed import EFFECTS, Concealed, conceal

__all__ = ['EFFECTS', 'Bench', 'Body', 'Concealed', 'Experiment', 'Signals', 'conceal', 'draw_body', 'observe']
