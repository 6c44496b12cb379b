"""The curve of a law without a name, as what the page's picture of it needs."""

from typing import Any

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import FreeLaw
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.report.as_read import CHANNEL_AXIS, shown
from tcp_muscle_ros.report.words import number, plain

LEFT, RIGHT, BOTTOM = 60.0, 352.0, 116.0  # of the frame, in the picture's units


def curve_picture(law: FreeLaw) -> dict[str, Any]:
    """The points of the curve and of its 90 % band, what stands at the axes, and the text alternative."""
    at = shown(law.driver, law.at)
    said = law.in_words
    drawn = [law.low, law.high, *([said.value] if said else [])]
    low, high = float(np.min(drawn)), float(np.max(drawn))
    room = 0.05 * (high - low) or 1.0

    def points(value: Array) -> list[str]:
        x = LEFT + (RIGHT - LEFT) * (at - at[0]) / max(float(np.ptp(at)), 1e-12)
        y = BOTTOM * (1.0 - (value - low + room) / (high - low + 2.0 * room))
        return [f'{a:.1f},{b:.1f}' for a, b in zip(x, y, strict=True)]

    driver = CHANNEL_AXIS.get(law.driver, plain(law.driver))
    first, last = (f'{number(float(law.value[k]))} {law.unit} at {number(float(at[k]))}' for k in (0, -1))
    return {
        'said': ' '.join(points(said.value)) if said else '',
        'curve': ' '.join(points(law.value)),
        'band': ' '.join(points(law.low) + points(law.high)[::-1]),
        'left': LEFT,
        'right': RIGHT,
        'bottom': BOTTOM,
        'low': number(low),
        'high': number(high),
        'from': number(float(at[0])),
        'to': number(float(at[-1])),
        'axis': f'{law.unit} over {driver}',
        'alternative': f'Curve over {driver}, with its 90 % band: from {first} to {last}'
        + (f'; dashed: {said.form}, the form in words' if said else ''),
    }
