"""Whether recordings say how far the state goes (how hot a muscle becomes), or only in which proportion.

Where no gauge was read, loss, capacity and gain trade against each other: a fit may pass through a stroke to its noise
at two degrees above the room or at eighty.
"""

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit


def anchored(fitted: Fit) -> bool:
    """Whether they fix it: the gauge of the state was read, or they fix the loss (``Model.loss``)."""
    return _read(fitted, {fitted.problem.model.gauge}) or _loss_is_fixed(fitted)


def measured(fitted: Fit) -> bool:
    """Whether they show it: the gauge was read; or they fix the loss, and a channel of the gauge's stage was read.

    A loss that the form of a stroke alone fixes is as good as that form: enough to name a temperature, not to heat by.
    """
    model = fitted.problem.model
    shown_by = model.shown_by.get(model.channels[model.gauge].stage, frozenset())
    return _read(fitted, {model.gauge}) or (_read(fitted, shown_by) and _loss_is_fixed(fitted))


def _read(fitted: Fit, channels: set[str] | frozenset[str]) -> bool:
    return any(channels & set(e.observed) for e in fitted.problem.experiments)


def _loss_is_fixed(fitted: Fit) -> bool:
    """Of each recording, where each has its own; one that is not fitted is as given."""
    problem = fitted.problem
    return all(
        u.fixed_by(float(fitted.covariance[k, k]) ** 0.5)
        for k, u in enumerate(problem.unknowns)
        if u.name == problem.model.loss
    )
