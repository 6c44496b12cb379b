"""One tick of one muscle from Python, and one period of the controller.

    python benchmarks/tick.py

The tick as sim_node makes it, a `Reading` included; the least work is a compiled call that does nothing with as many
arrays. The controller's period is feed-forward through the inverse, the observer, and the model over the period.
"""

import numba
import numpy as np
from side_by_side import Contender, in_turns, show

from tcp_muscle_ros.control.tracking import TrackingController
from tcp_muscle_ros.muscle import Muscle, Parameters

PAPER = Parameters.named('karami_tadesse_2017')
FIVE = PAPER.with_effects('natural_convection', 'radiation', 'creep', 'hysteresis', 'thermocouple_lag')
CALLS = 2000


@numba.njit(_nrt=False)
def nothing(x, u, p, on, q, work, dt, y):
    """Takes what a tick takes."""


def calls(work) -> Contender:
    """So many calls in a row."""
    name, call = work

    def run() -> None:
        for _ in range(CALLS):
            call()

    return Contender(name, run)


def main() -> None:
    """Both tables."""
    x, u, p, q, scratch, y = (np.zeros(n) for n in (40, 8, 120, 80, 240, 11))
    on = np.zeros(40, np.bool_)
    muscles = {model: Muscle(model, load=0.5) for model in (PAPER, FIVE)}
    for title, works in (
        (
            'One tick of one muscle from Python (aim: 5 us)',
            (
                ('least: an empty compiled call', lambda: nothing(x, u, p, on, q, scratch, 0.01, y)),
                ("ours: `Muscle.step`, the paper's model", lambda: muscles[PAPER].step(0.01, 0.2)),
                ('ours: `Muscle.step`, five effects', lambda: muscles[FIVE].step(0.01, 0.2)),
            ),
        ),
        ('One period of the controller (aim: 50 us)', tuple(periods())),
    ):
        measured = in_turns([calls(work) for work in works])
        floor = measured[0].seconds
        show(
            title, ('', 'us', 'over the first'),
            [(row.name, f'{1e6 * row.seconds / CALLS:.2f}', f'{row.seconds / floor:.1f}') for row in measured],
        )  # fmt: skip


def periods():
    """The controller's update, by mode and by what the model has; first the rollout alone."""
    rolled = Muscle(PAPER, load=0.5)
    yield "the model's step in it, alone", lambda: rolled.step(0.01, 0.2)
    for name, model, settings in (
        ('ours: feed-forward, observer and rollout', PAPER, {}),
        ('ours: the same, five effects in the rollout', FIVE, {}),
        ('ours: PID with the same guards', PAPER, {'mode': 'pid'}),
    ):
        controller = TrackingController(model, 0.01, 0.27, 0.5, PAPER['T0'], **settings)

        def period(controller=controller) -> None:
            controller.update(0.01, displacement=0.005, applied_current=0.2)

        yield name, period


if __name__ == '__main__':
    main()
