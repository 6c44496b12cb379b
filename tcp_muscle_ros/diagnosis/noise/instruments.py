"""What instruments do beside the noise of single readings: how far each usually wanders within a recording.

What is slow and larger is not the instrument's: it is misfit, and is not taken for noise.
"""

import numpy as np

from tcp_muscle_ros.diagnosis.model.model import Channel

# An instrument that is better than these in single readings wanders less too: by so many times their noise at most.
_MOST = 5.0


def largest_noise(channel: Channel | None, single: float, times: float) -> float:
    """The largest standard deviation (SI) that a channel's noise may have whose ``single`` readings have that one.

    They tell it to a share (colour between neighbours, quantisation): it is so many ``times`` as large at most, beside
    what the instrument wanders.
    """
    allowed = _MOST * single if channel is None else float(np.hypot(times * single, channel.wander))
    return min(_MOST * single, allowed)
