"""What is gained: errors on unseen data without and with what was found, and how far a strength is from nothing.

Errors are those of single samples, as ``tcp_muscle replay`` prints them, also where samples were averaged for the fit:
what of them is white within a block (``Observed.within``) no model foretells, and it is added.
"""

from collections.abc import Mapping

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import Change, ChannelFit, Value, strengths
from tcp_muscle_ros.diagnosis.fitting import draught, slips
from tcp_muscle_ros.diagnosis.fitting.least_squares import WIDTH, Fit
from tcp_muscle_ros.diagnosis.model.model import floating
from tcp_muscle_ros.diagnosis.noise.noise import over_all
from tcp_muscle_ros.diagnosis.search.holdout import changed_by, held_out
from tcp_muscle_ros.diagnosis.search.refitting import shrink
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.muscle import Parameters


def of_samples(fitted: Fit, errors: Mapping[str, float]) -> dict[str, float]:
    """Root mean square errors (SI) by channel of single samples, from those of the values that were fitted."""
    observed = [o for e in fitted.problem.experiments for o in e.observed.items()]
    found = {}
    for name, error in errors.items():
        mine = [(o.within, float(o.count.sum())) for channel, o in observed if channel == name]
        within = sum(w * n for w, n in mine) / max(sum(n for _, n in mine), 1.0)
        found[name] = float(np.sqrt(error**2 + within))
    return found


def fits(selection: Selection, nominal: Parameters) -> dict[str, ChannelFit]:
    """The errors of each channel: nominal, recalibrated and improved on what was fitted, and on unseen data."""
    final = selection.final
    before, after = (of_samples(final, unseen.rmse()) for unseen in (selection.before, selection.after))
    shown = nominal_predictions(final, nominal)
    models = (
        [
            {name: o.value - mine[name] for name, o in e.observed.items()}
            for e, mine in zip(final.problem.experiments, shown, strict=True)
        ],
        selection.calibrated.left,
        selection.best.left,
    )
    errors = [of_samples(final, _root_mean_square(left)) for left in models]
    noise = noises(selection)
    found = {}
    for name in noise:
        nominal_error, calibrated, improved = (mine[name] for mine in errors)
        unseen = Change(before[name], after[name]) if name in before and name in after else None
        found[name] = ChannelFit(nominal_error, calibrated, improved, noise[name], unseen, improved)
    return found


def noises(selection: Selection) -> dict[str, float]:
    """The standard deviation (SI) of each channel's noise, of single samples, over all recordings as errors are."""
    noise = {name: s.noise for name, s in selection.structure_after.items()}
    return of_samples(selection.final, over_all(selection.final.problem.experiments, noise))


def nominal_predictions(fitted: Fit, nominal: Parameters) -> list[dict[str, np.ndarray]]:
    """What the nominal muscle shows, each recording at rest at its stated ambient, zeros of the rig taken out."""
    found = []
    for experiment in fitted.problem.followed:
        predicted = experiment.predict(nominal)
        for name in floating(fitted.problem.model):
            if name in predicted:
                predicted[name] = predicted[name] + np.mean(experiment.observed[name].value - predicted[name])
        found.append(predicted)
    return found


def own_improvement(selection: Selection, effect: str) -> dict[str, Change]:
    """What one finding improves on unseen data: all findings without it, and with it, in the channels it changes.

    Without it all else is fitted anew, as it would be if nobody had thought of it.
    """
    final = selection.final
    without = fitted_without(selection, effect)
    changed = {slip.channel for slip in final.problem.slips} if _at_instants(final, effect) else None
    before = of_samples(final, held_out(without, selection.kept_back).rmse())
    after = of_samples(final, selection.after.rmse())
    channels = (changed_by(final, effect) if changed is None else changed) or set(after)
    return {name: Change(before[name], after[name]) for name in after if name in channels and name in before}


def fitted_without(selection: Selection, effect: str) -> Fit:
    """The fit without one of the effects that were chosen, all else fitted anew."""
    if len(selection.chosen) == 1 and selection.leapt is None:
        return selection.calibrated
    if _at_instants(selection.final, effect):
        return slips.taken_out(selection.final)
    fitted = (
        draught.without_course(selection.final)
        if effect in selection.final.problem.model.roles.inferred
        else selection.final
    )
    return shrink(fitted, effect)


def _at_instants(fitted: Fit, effect: str) -> bool:
    """Whether an effect is in a fit as slips at instants of their own, and not as the flow that it is in the mean."""
    return effect == fitted.problem.model.roles.slips and effect not in fitted.problem.parameters.effects


def certainty(effect: str, values: Mapping[str, Value]) -> float:
    """The largest probability that an effect is there at all, by how far its strength is from that of no effect.

    No prior makes the odds for an effect whose strength lies z standard deviations from nothing larger than exp(z^2/2)
    to 1 (Edwards, Lindman & Savage 1963): with an interval of 90 % that reaches nothing, 0.79.
    """
    far = [0.0]
    for value, none in strengths(effect, values):
        nearer = value.low if value.value > none else value.high
        spread = abs(value.value - nearer) / WIDTH
        far.append(abs(value.value - none) / spread if spread > 0.0 else np.inf)
    if len(far) == 1:
        return 1.0
    return float(1.0 / (1.0 + np.exp(-0.5 * min(max(far), 30.0) ** 2)))


def _root_mean_square(left: list[dict[str, np.ndarray]]) -> dict[str, float]:
    names = sorted({name for mine in left for name in mine})
    return {name: float(np.sqrt(np.mean(np.concatenate([m[name] for m in left if name in m]) ** 2))) for name in names}
