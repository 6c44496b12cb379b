"""How probable it is that a finding is there: what speaks for it, weighed as it proved right on known muscles.

The share of the likelihood among rivals is no probability: no listed form is the muscle's own, and physics that is not
listed competes with nothing. So the log odds of a finding are a sum of a few terms, each of which a reader would ask
for too. Their weights are in the policy; ``scripts/calibrate`` fits them on muscles whose physics is known (logistic
regression, Platt 1999).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import Finding, Value
from tcp_muscle_ros.diagnosis.answer.improvement import certainty
from tcp_muscle_ros.diagnosis.search.selected import Chosen, Selection

_CERTAIN = 1e-4  # nearer to 0 or 1 a share says no more
_SCALE = 4.0  # of log odds: terms are about as large as 1
_USUAL_DROP = 1000.0
_FEW = 3  # recordings

# The terms by name, with what each is; the policy has a weight for each of them.
TERMS: Mapping[str, str] = {
    'constant': '1',
    'among_rivals': 'log odds of its share of the likelihood among its rivals, over 4',
    'not_nothing': 'log odds that its strength is not zero, over 4',
    'drop': 'log10 of the drop of the misfit over 1000',
    'at_bound': '1 where one of its parameters is at the end of its range',
    'circumstance': '1 where it differs from recording to recording, as a room or a draught',
    'sensor': '1 where it is a fault of an instrument',
    'weaker': '1 where a stronger one was found',
    'others': 'how many others were found',
    'few': '1 where there are fewer than three recordings',
    'left': '1 where something remains unexplained',
}
# The verdicts that name nothing, with what each claims. How often it was right, as log odds, stands beside the weights.
NAMELESS: Mapping[str, str] = {
    'match': 'nothing is missing that these recordings could show',
    'wrong_parameters': 'nothing is missing that these recordings could show, with other numbers',
    'unexplained': 'something is missing, in the muscle or in its instruments',
}


def terms(selection: Selection, chosen: Chosen, values: Mapping[str, Value], anything_left: bool) -> dict[str, float]:
    """What speaks for a finding with these fitted ``values``, by the names of ``TERMS``."""
    definition = chosen.definition
    return {
        'constant': 1.0,
        'among_rivals': _log_odds(chosen.confidence),
        'not_nothing': _log_odds(certainty(chosen.effect, values)),
        'drop': float(np.log10(max(chosen.drop, 1.0) / _USUAL_DROP)),
        'at_bound': float(any(v.at_bound for v in values.values())),
        'circumstance': float(definition.circumstance),
        'sensor': float(definition.stage == 'sensor'),
        'weaker': float(chosen is not selection.chosen[0]),
        'others': float(len(selection.chosen) - 1),
        'few': float(len(selection.final.problem.experiments) < _FEW),
        'left': float(anything_left),
    }


def probability(found: Mapping[str, float], weights: Mapping[str, float]) -> float:
    """The probability that terms give under these weights, both by name."""
    return float(1.0 / (1.0 + np.exp(-sum(weights[name] * value for name, value in found.items()))))


def of_verdict(verdict: str, found: Sequence[Finding], weights: Mapping[str, float]) -> float | None:
    """The probability that a verdict is right, None where it has none.

    Of one that names something: that at least one of its findings is there. Of one that names nothing: how often it was
    right on muscles whose physics is known (``weights``). ``insufficient_data`` claims nothing, and of muscles that do
    not repeat themselves there are no known ones.
    """
    if verdict in NAMELESS:
        return probability({verdict: 1.0}, weights)
    sensors = verdict == 'sensor_or_setup'
    if verdict != 'missing_physics' and not sensors:
        return None
    absent = [1.0 - f.probability for f in found if (f.stage == 'sensor') == sensors]
    return 1.0 - float(np.prod(absent))


def _log_odds(share: float) -> float:
    share = float(np.clip(share, _CERTAIN, 1.0 - _CERTAIN))
    return float(np.log(share / (1.0 - share))) / _SCALE
