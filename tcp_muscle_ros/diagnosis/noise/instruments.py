"""What instruments do beside the noise of single readings: how far each usually wanders within a recording.

What is slow and larger is not the instrument's: it is misfit, and is not taken for noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Instrument:
    """``wander``: standard deviation (SI) of what it shows beside the truth, slowly, over minutes; ``source``."""

    wander: float
    source: str


INSTRUMENTS: Mapping[str, Instrument] = {
    'temperature': Instrument(0.1, 'thermocouple amplifiers: cold junction follows the board by 0.1 to 0.25 K'),
    'resistance': Instrument(0.015, 'voltage over current, each to 0.05 to 0.1 % of 14 ohm'),
    'displacement': Instrument(4e-5, 'laser triangulation over 50 mm: linearity and drift 0.06 to 0.1 % of the range'),
    'force': Instrument(2e-3, 'load cells of 10 N: creep 0.02 %'),
}
# An instrument that is better than these in single readings wanders less too: by so many times their noise at most.
_MOST = 5.0


def largest_noise(channel: str, single: float, times: float) -> float:
    """The largest standard deviation (SI) that a channel's noise may have whose ``single`` readings have that one.

    They tell it to a share (colour between neighbours, quantisation): it is so many ``times`` as large at most, beside
    what the instrument wanders.
    """
    known = INSTRUMENTS.get(channel)
    allowed = _MOST * single if known is None else float(np.hypot(times * single, known.wander))
    return min(_MOST * single, allowed)
