"""What remains when the search has ended: misfit that no effect took away."""

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.noise.noise import quick_noise
from tcp_muscle_ros.diagnosis.search.location import Unexplained, locate
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.diagnosis.search.shared import agreeing, shared_misfit

_BEYOND, _PLAIN, _FAR_BEYOND = 1.5, 4.0, 8.0  # times the noise's variance
_AROUND = 5.0  # s before and after a leap


def unexplained(selection: Selection) -> Unexplained | None:
    """What remains, if it is real and no trifle beside what was there; what leapt is taken out, not explained."""
    leapt, policy = _leaps(selection), selection.final.problem.policy
    if leapt is not None and leapt.share >= policy.still:
        return leapt
    after = selection.structure_after
    had, has = selection.calibrated.mean_square, selection.final.mean_square
    sensors = all(c.definition.stage == 'sensor' for c in selection.chosen)
    left: dict[str, tuple[float, float]] = {}
    for name, s in after.items():
        missed = has[name] - s.noise.sigma**2
        # Beyond the noise it is real even where no regularity predicts it; far beyond, even where none is found.
        beyond = missed / s.noise.sigma**2
        if (s.significant and (s.confirmed or beyond > _BEYOND)) or beyond > _FAR_BEYOND:
            share = missed / max(had[name] - s.noise.sigma**2, 1e-300) if selection.chosen else 1.0
            # Sensors' faults are told exactly.
            if share >= (policy.still_plain if sensors or beyond > _PLAIN else policy.still):
                left[name] = beyond, share
    channel = max(left, key=lambda name: left[name], default=None)
    if channel is None:
        together = wandering(selection)
        return together if together is not None and together.share >= policy.still else None
    share = left[channel][1]
    place = locate(selection.final, after, channel)
    driver = place.drivers[0]
    recording, start, end = place.intervals[0]
    return Unexplained(
        _stage(selection.final, (channel,)),
        channel,
        min(share, 1.0),
        driver.variable,
        driver.low,
        driver.high,
        (recording, start, end),
    )


def _stage(fitted: Fit, missed: tuple[str, ...]) -> str:
    """The stage in which channels are missed: a channel that goes together with one of another stage follows the heat,
    however plainly it shows it itself."""
    channels = fitted.problem.model.channels
    together = {name for pair in agreeing(fitted) if set(missed) & set(pair.channels) for name in pair.channels}
    stages = {channels[name].stage for name in (*missed, *together)}
    return stages.pop() if len(stages) == 1 else 'thermal'


def _leaps(selection: Selection) -> Unexplained | None:
    """What leapt from one instant to the next for good, if that was no trifle."""
    if selection.leapt is None:
        return None
    had, has, problem = selection.calibrated.mean_square, selection.leapt.mean_square, selection.leapt.problem
    leaping = sorted({slip.channel for slip in problem.slips})
    went = {name: 1.0 - has[name] / had[name] for name in leaping}
    channel = max(went, key=lambda name: went[name])
    when = [
        (k, e.imposed.time[0], slip)
        for k, (e, latent) in enumerate(zip(problem.experiments, problem.latents, strict=True))
        for slip in latent.slips
        if slip.channel == channel
    ]
    elapsed = [slip.time - start for _, start, slip in when]
    k, _, largest = max(when, key=lambda found: abs(found[2].size))
    around = (k, largest.time - _AROUND, largest.time + _AROUND)
    return Unexplained(
        problem.model.channels[channel].stage, channel, went[channel], 'elapsed', min(elapsed), max(elapsed), around
    )


def wandering(selection: Selection) -> Unexplained | None:
    """What several channels see and no effect takes away: unexplained, however irregular."""
    found = shared_misfit(selection.final)
    if found is None:
        return None
    floor = quick_noise(selection.final.problem.experiments)
    channels = selection.final.problem.model.channels
    channel = min(found.channels, key=tuple(channels).index)
    k, start, end = found.interval
    begin = float(selection.final.problem.experiments[k].imposed.time[0])
    had, has = (fit.mean_square[channel] - floor[channel].sigma ** 2 for fit in (selection.calibrated, selection.final))
    share = min(has / had, 1.0) if selection.chosen else 1.0
    return Unexplained(
        _stage(selection.final, found.channels), channel, share, 'elapsed', start - begin, end - begin, found.interval
    )
