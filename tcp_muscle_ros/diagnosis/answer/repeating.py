"""How well runs of one protocol repeat each other, what each run has for itself, and how that is said."""

from collections.abc import Mapping, Sequence

import numpy as np

from tcp_muscle_ros.diagnosis.answer.doubtful import without
from tcp_muscle_ros.diagnosis.answer.findings import Run, RunToRun
from tcp_muscle_ros.diagnosis.answer.improvement import own_improvement
from tcp_muscle_ros.diagnosis.answer.sentences import none_explains, quantity
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.hypothesis.latents import Latent
from tcp_muscle_ros.diagnosis.noise.repeatability import SCALES, Repeatability
from tcp_muscle_ros.diagnosis.noise.replicates import protocols
from tcp_muscle_ros.diagnosis.search.location import Unexplained, locate
from tcp_muscle_ros.diagnosis.search.remaining import unexplained
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.muscle import Parameters

_PLAINLY = 1.5  # times what differs from run to run: more has another cause
_TOLD = 1.2  # times: a factor that is worth saying


def run_to_run(
    selection: Selection, nominal: Parameters, repeated: Mapping[str, Repeatability], apart: Sequence[str]
) -> RunToRun | None:
    """How runs of one protocol differ; None where there are no two.

    Args:
        selection: what was found.
        nominal: where the calibration of each run's own values starts.
        repeated: what runs of one protocol do not share, by channel.
        apart: the channels in which they differ by more than noise, and which were allowed to.
    """
    if not repeated:
        return None
    problem = selection.final.problem
    own = any(u.recording is not None and u.name == problem.model.gain for u in problem.unknowns)
    sizes = {name: (found.own_gain if own else found.plain) * found.peak for name, found in repeated.items()}
    if not apart:
        return RunToRun(sizes)
    channel = max(apart, key=lambda name: repeated[name].own_gain)
    found = repeated[channel]
    several = [protocol.recordings for protocol in protocols(selection.final.problem.followed)]
    error = _error(selection.final, channel, several)
    runs = _runs(selection.final, nominal, channel, several)
    return RunToRun(sizes, channel, found.own_gain, found.plain, error, own, runs, found.by_scale)


def _error(fitted: Fit, channel: str, several: Sequence[Sequence[int]]) -> float:
    """Root mean square of what the model misses in the runs that are repeated, as a share of each run's peak."""
    experiments = fitted.problem.experiments
    seen = [k for runs in several for k in runs if channel in experiments[k].observed]
    return float(np.sqrt(np.mean([_share(fitted, k, channel) ** 2 for k in seen])))


def _share(fitted: Fit, k: int, channel: str) -> float:
    left, seen = fitted.left[k][channel], fitted.problem.experiments[k].observed[channel].value
    return float(np.sqrt(np.mean(left**2))) / max(float(np.ptp(seen)), 1e-300)


def _runs(fitted: Fit, nominal: Parameters, channel: str, several: Sequence[Sequence[int]]) -> tuple[Run, ...]:
    """Gain and time constant of each run, fitted to all of them with these two for each."""
    experiments, model = fitted.problem.experiments, fitted.problem.model
    switched = [Latent(switched=latent.switched) for latent in fitted.problem.latents]
    each = calibrate(experiments, nominal, latents=switched, separate=(model.gain, model.capacity))
    gains = {e.recording: e.value for e in each.estimates if e.name == model.gain}
    slow = {e.recording: e.value for e in each.combinations if e.name == model.slowness}
    usual = float(np.exp(np.mean(np.log(list(gains.values())))))
    of = {k: number for number, runs in enumerate(several, 1) for k in runs}
    return tuple(
        Run(e.name, of.get(k), gains[k] / usual, slow[k], _share(fitted, k, channel))
        for k, e in enumerate(experiments)
        if channel in e.observed
    )


def beyond_what_differs(selection: Selection, repeated: Mapping[str, Repeatability]) -> Selection:
    """The selection without what lowers the mean square error on unseen data by less than what runs of one protocol
    differ by, in the channels in which they do: physics and sensors alike."""
    for chosen in sorted(selection.chosen, key=lambda c: c.drop):
        if chosen.effect == selection.final.problem.model.roles.slips:  # they are seen one by one
            continue
        changes = own_improvement(selection, chosen.effect)
        if set(changes) <= set(repeated) and not any(
            change.before**2 - change.after**2 > (repeated[name].own_gain * repeated[name].peak) ** 2
            for name, change in changes.items()
        ):
            selection = without(selection, chosen.effect)
    return selection


def left_unexplained(selection: Selection, found: RunToRun | None) -> Unexplained | None:
    """What remains unexplained; in a channel in which runs of one protocol differ, what goes plainly beyond that."""
    remains = unexplained(selection.told) or selection.unnamed
    if found is None or not found.channel or (remains is not None and remains.channel != found.channel):
        return remains
    if found.error < _PLAINLY * found.repeatability:
        return None
    place = locate(selection.final, selection.structure_after, found.channel)
    driver, share = place.drivers[0], 1.0 - (found.repeatability / found.error) ** 2
    return Unexplained(place.stage, found.channel, share, driver.variable, driver.low, driver.high, place.intervals[0])


def said_of_runs(found: RunToRun | None, tried: bool = True) -> str:
    """That the runs are predicted as well as they repeat each other or less well, and by what they differ; '' where
    they do not. ``tried``: whether any effect was."""
    if found is None or not found.channel:
        return ''
    if found.error >= _PLAINLY * found.repeatability:
        return (
            f'The {quantity(found.channel)} is predicted to {100.0 * found.error:.1f} % of its peak, while runs of the '
            f'same protocol repeat each other to {100.0 * found.repeatability:.1f} %. '
            f'{none_explains(tried)} the error that they have in common.'
        )
    return (
        f'The {quantity(found.channel)} is predicted to {100.0 * found.error:.1f} % of its peak; runs of the same '
        f'protocol repeat each other to {100.0 * found.repeatability:.1f} %'
        f'{" with a gain of its own for each" if found.own_gain else ""}. What remains differs from run to run, and '
        f'no model of one muscle predicts it{_factors(found.runs)}.'
    )


def _factors(runs: Sequence[Run]) -> str:
    """By what factor gains and time constants differ among runs of one protocol."""
    said = []
    for what, name in (('gains', 'gain'), ('time constants', 'time_constant')):
        ratios = [
            max(values) / min(values)
            for number in {run.protocol for run in runs} - {None}
            for values in [[getattr(run, name) for run in runs if run.protocol == number]]
            if len(values) > 1 and min(values) > 0.0
        ]
        if ratios and max(ratios) > _TOLD:
            said.append(f'{what} differ by a factor of up to {max(ratios):.1f}')
    return ': ' + ' and '.join(said) if said else ''


def notes_on_runs(found: RunToRun | None) -> tuple[str, ...]:
    """That runs of one protocol differ, and what was done about it."""
    if found is None or not found.channel:
        return ()
    name, gain = quantity(found.channel), ''
    if found.own_gain:
        gain = (
            f'each recording was given a gain of its own (without it they differ by {100.0 * found.plain:.1f} %; '
            f'improved.yaml has the mean), and '
        )
    return (
        f'runs of one protocol differ in the {name} by {100.0 * found.repeatability:.1f} % of the peak'
        f'{_scales(found)}: {gain}an effect is named only where it explains more than this difference',
    )


def _scales(found: RunToRun) -> str:
    """How quick that is by which runs differ: jumps, or another course."""
    quick, slow = SCALES
    names = (f'quicker than {quick:g} s', f'from {quick:g} to {slow:g} s', 'slower')
    said = [f'{100.0 * s:.1f} % {name}' for name, s in zip(names, found.scales, strict=False) if np.isfinite(s)]
    return f' ({", ".join(said)})' if said else ''
