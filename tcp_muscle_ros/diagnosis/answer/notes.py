"""What is said of slips, of leaps, and of what several channels see at once: none of it has a name."""

from tcp_muscle_ros.diagnosis.answer.sentences import amount
from tcp_muscle_ros.diagnosis.search.location import Unexplained
from tcp_muscle_ros.diagnosis.search.selection import Selection
from tcp_muscle_ros.diagnosis.search.shared import shared_misfit, wandering


def on_slips(selection: Selection) -> tuple[str, ...]:
    """Which slips were found, the effect having their mean only; or which leaps, that have no name."""
    each = []
    problem = selection.final.problem
    for e, latent in zip(problem.experiments, problem.latents, strict=True):
        said = [
            f'{slip.time - e.imposed.time[0]:.1f} s ({amount(slip.channel, abs(slip.size))})'
            for slip in sorted(latent.slips, key=lambda slip: slip.time)
        ]
        each += [f'{e.name} at {", ".join(said)}'] if said else []
    if not each:
        return ()
    what = 'the end slipped suddenly' if selection.leapt is None else 'a reading changed suddenly and for good'
    better = 'has their mean rate' if selection.leapt is None else 'does not contain them'
    return (
        f'{what}: {"; ".join(each)}; no model predicts these instants, so they are taken from the recordings, also '
        f'from held-out ones; improved.yaml {better}',
    )


def on_shared(selection: Selection, unexplained: Unexplained | None) -> tuple[str, ...]:
    """Where that is what is ``unexplained``: that it is no noise, and how it is known."""
    found = shared_misfit(selection.final)
    if found is None or unexplained != wandering(selection):
        return ()
    one, two = found.channels
    return (
        f'the remaining errors of {one} and {two} are correlated ({found.correlation:.2f}), which noise is not: '
        f'something outside the muscle acts on both, such as a draught, a drifting room or an unstable supply',
    )
