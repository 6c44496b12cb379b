"""What is said of slips and leaps: a leap has no name, and no model foretells when either comes."""

from tcp_muscle_ros.diagnosis.findings import Unexplained
from tcp_muscle_ros.diagnosis.location import STAGE_OF
from tcp_muscle_ros.diagnosis.selection import Selection
from tcp_muscle_ros.diagnosis.sentences import amount

_AROUND = 5.0  # s before and after a leap


def leaps(selection: Selection) -> Unexplained | None:
    """What leapt from one instant to the next for good, if that was no trifle."""
    if selection.leapt is None:
        return None
    had, has = selection.calibrated.mean_square, selection.leapt.mean_square
    leaping = sorted({slip.channel for e in selection.leapt.problem.experiments for slip in e.slips})
    went = {name: 1.0 - has[name] / had[name] for name in leaping}
    channel = max(went, key=lambda name: went[name])
    when = [
        (k, e.imposed.time[0], slip)
        for k, e in enumerate(selection.leapt.problem.experiments)
        for slip in e.slips
        if slip.channel == channel
    ]
    elapsed = [slip.time - start for _, start, slip in when]
    k, _, largest = max(when, key=lambda found: abs(found[2].size))
    around = (k, largest.time - _AROUND, largest.time + _AROUND)
    return Unexplained(STAGE_OF[channel], channel, went[channel], 'elapsed', min(elapsed), max(elapsed), around)


def notes(selection: Selection) -> tuple[str, ...]:
    """Which slips were found, the effect having their mean only; or which leaps, that have no name."""
    each = []
    for e in selection.final.problem.experiments:
        said = [
            f'{slip.time - e.imposed.time[0]:.1f} s ({amount(slip.channel, abs(slip.size))})'
            for slip in sorted(e.slips, key=lambda slip: slip.time)
        ]
        each += [f'{e.name} at {", ".join(said)}'] if said else []
    if not each:
        return ()
    what = 'the end slipped suddenly' if selection.leapt is None else 'what is shown leapt at once, and for good'
    better = 'has their mean rate' if selection.leapt is None else 'knows nothing of them'
    return (
        f'{what}: {"; ".join(each)}; no model foretells these instants, so they are taken from the recordings, the '
        f'held out ones too; improved.yaml {better}',
    )
