"""Rivals: models that compete for the place of one effect, and which of them is named."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import robust_noise, structures, with_noise
from tcp_muscle_ros.diagnosis.model.unknown import Unknown
from tcp_muscle_ros.muscle import Effect
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.settings.policy import Policy

CONTEST = 0.2  # of the best rival's drop: rivals that close are compared once more
_END = 1e-4  # relative
_NEARLY = 1.1  # times half the span of what an effect needs to be crossed, from its middle
# What begins in so many recordings within so many s after a switch (a share of the drive's span) is no chance.
_SEVERAL, _TOGETHER, _SWITCH = 3, 2.0, 0.05
_RESOLVED = 0.5  # of the time from sample to sample: an instant between two is known to so much
_BEST = 0.05  # of these times are no longer, where a recording is read best
# Times the usual drop: what may begin and end anywhere, or differs from recording to recording; and a trace of physics.
_ANYWHERE, _FAINTLY = 2.0, 10.0
_PLAINLY = np.log(3.0) / np.log(20.0)  # of the margin, which is odds of 20 to 1: odds of 3 to 1


@dataclass(frozen=True)
class Rival:
    """A model that competes for the place of one effect: the fit, and its objective."""

    effect: str
    fit: Fit
    score: float

    @property
    def definition(self) -> Effect:
        """What the effect says of itself."""
        return self.fit.problem.model.effects[self.effect]

    @property
    def policy(self) -> Policy:
        """What decides whether it is named."""
        return self.fit.problem.policy


def margin(drop: float, policy: Policy) -> float:
    """The difference of scores below which two models are not told apart, given what both explain.

    No listed form is quite the muscle's own: where two explain nearly the same, form decides nothing, however many
    samples there are.
    """
    return max(policy.told_apart, policy.alike * drop)


def close_rivals(rivals: Sequence[Rival], drop: float, share: float = 1.0) -> list[Rival]:
    """Those that are not told from the best; ``share``: by so much of the margin."""
    best = min(r.score for r in rivals)
    return [r for r in rivals if r.score - best < share * margin(drop, r.policy)]


def truer(rivals: Sequence[Rival], named: str, drop: float) -> Rival | None:
    """The physics that fits best, where another of these rivals is named in its place for being simpler.

    What the simpler form leaves hides what stands beside it: that is sought, and judged, beside this one.
    """
    best = min(rivals, key=lambda r: r.score)
    simple = next((r for r in close_rivals(rivals, drop) if r.effect == named), None)
    if simple is None or own(best) or not best.definition.of_muscle or not begins(best):
        return None
    return best if simple.score - best.score >= best.policy.told_apart else None


def penalised(fitted: Fit) -> float:
    """The objective with a price on parameters of effects, so that a flexible rival does not win by flexibility."""
    count = sum('.' in u.name for u in fitted.problem.unknowns)
    return fitted.objective + fitted.problem.policy.per_parameter * count


def begins(rival: Rival) -> bool:
    """Whether it is there at all, not next to nothing; and what it is may be so (``sound``)."""
    policy = rival.policy
    # Of a sensor or a room the log knows the instants and inputs no better than to a few per cent.
    least = policy.trace_of_physics if rival.definition.of_muscle else policy.trace_of_circumstance
    return _largest(rival) >= least and sound(rival)


def sound(rival: Rival) -> bool:
    """Whether the muscle crosses, or nearly, what the effect needs to be crossed; its strength is not as far as it
    goes, nor are two of its numbers (of physics that acts the other way round, not one); samples resolve how late it
    makes something; and no sensor is far off in most recordings. Else it is another one in disguise."""
    definition = rival.definition
    if not _resolved(rival) or (definition.stage == 'sensor' and own(rival) and _off_beyond_use(rival)):
        return False
    if _spent(rival) or _ends(rival) > (0 if turned(rival) else 1) or (definition.moments and follows_the_drive(rival)):
        return False
    for row in definition.moved(rival.fit.muscle):
        if row.crossed:
            shown = np.concatenate([getattr(o, row.crossed) for o in rival.fit.outputs])
            middle, reach = 0.5 * (shown.max() + shown.min()), _NEARLY * 0.5 * (shown.max() - shown.min())
            around = rival.fit.muscle[f'{rival.effect}.{row.around}'] if row.around else 0.0
            if abs(rival.fit.muscle[f'{rival.effect}.{row.name}'] - middle) > reach + around:
                return False
    return True


def _off_beyond_use(rival: Rival) -> bool:
    """Whether a sensor is off as none in use is, in most recordings or by nearly the same in each: rooms and the rest
    of the muscle move along then, and only how they differ is seen."""
    strengths = _strengths(rival, fixed=True)
    if not strengths.size:
        return False
    most, alike = np.median(np.abs(strengths)), abs(np.mean(strengths))
    return bool(most > rival.policy.beyond_use or alike > max(rival.policy.beyond_use, float(np.ptp(strengths))))


def _resolved(rival: Rival) -> bool:
    """Whether samples resolve, where they lie closest, by how much it makes something late, if that is what it shows.

    A clock, a lag of the supply and one of the core are held to the same: one output does not tell them apart.
    """
    late = _late(rival)
    seen = [
        o.spacing or float(np.quantile(np.diff(o.time), _BEST))
        for e in rival.fit.problem.experiments
        for o in e.observed.values()
        if o.time.size > 1
    ]
    return late is None or bool(late >= _RESOLVED * min(seen, default=0.0))


def _late(rival: Rival) -> float | None:
    """By how much it makes something follow the drive, s. A clock does only where there is one output: what two of
    them show at once, they show to less than a sample."""
    definition, muscle, experiments = rival.definition, rival.fit.muscle, rival.fit.problem.experiments
    if definition.delay is not None:
        return float(definition.delay(muscle))
    if definition.late is None or len({name for e in experiments for name in e.observed}) > 1:
        return None
    delay, pace = (muscle[f'{rival.effect}.{name}'] for name in definition.late[:2])
    return float(delay + pace * max(np.ptp(e.imposed.time) for e in experiments))


def least_drop(rival: Rival) -> float:
    """What it must lower the score by: more than chance gives. Physics that is fainter than is known of the fibre looks
    like the rest of many things, and must be plain."""
    effect, policy = rival.definition, rival.policy
    anywhere = own(rival) or (effect.circumstance and effect.stage != 'sensor')
    faint = effect.of_muscle and abs(times_usual(rival)) < policy.faint
    return policy.least_drop * (_FAINTLY if faint else _ANYWHERE if anywhere else 1.0)


def follows_the_drive(rival: Rival) -> bool:
    """Whether what begins at an instant begins in every recording equally long after a switch of the drive.

    A circumstance does not know the drive: what does is a law of the muscle or of the rig. Two recordings may agree by
    chance.
    """
    values, begin = rival.fit.values, f'{rival.effect}.{rival.definition.moments[0]}'
    since = []
    for k, experiment in enumerate(rival.fit.problem.followed):
        drive, time = experiment.imposed.drive, experiment.imposed.time
        switched = time[1:][np.abs(np.diff(drive)) > _SWITCH * max(float(np.ptp(drive)), 1e-12)]
        at = values.get((begin, k), values.get((begin, None), 0.0))
        before = switched[switched <= at + _TOGETHER]
        if before.size == 0:
            return False
        since.append(at - float(before[-1]))
    return len(since) >= _SEVERAL and float(np.ptp(since)) < _TOGETHER


def rescored(bare: Fit, rivals: Sequence[Rival]) -> tuple[float, list[Rival]]:
    """The close rivals, and the score without any, under the noise that the best of them leaves.

    Under the noise of the poorer model, into which its misfit counts, good models look alike.
    """
    drop = penalised(bare) - rivals[0].score
    noise = robust_noise(rivals[0].fit, structures(rivals[0].fit))
    refitted = []
    for rival in rivals:
        if rival.score - rivals[0].score < CONTEST * drop:
            again = with_noise(rival.fit, noise)
            refitted.append(Rival(rival.effect, again, penalised(again)))
    alone = with_noise(bare, noise)
    return penalised(alone), sorted(refitted, key=lambda r: r.score)


def prefer(rivals: Sequence[Rival], bare: float) -> Rival:
    """The best model; among those that it does not beat, the simplest.

    A sensor that is off as none in use is none of them where physics as it is known explains the same. The simplest is
    one that holds for all recordings alike, then a sensor before physics (unless it is off as hardly any ever is, and
    physics as it is known would do), then what acts as it is known to and not the other way round, then what is
    expected of the fibre, then the fewest parameters. In one stage, where form decides, a form with more parameters
    follows another's by what it may bend: it must be more than alike to win, of physics plainly more probable. What had
    to be bent as far as it goes is not alike, and where another one explains more it is not among the simplest.
    ``bare`` is the score without any of them.
    """
    best, policy = min(r.score for r in rivals), rivals[0].policy
    if any(_known(r) for r in close_rivals(rivals, bare - best)):
        rivals = [r for r in rivals if not _beyond_belief(r)]
        best = min(r.score for r in rivals)
    bends = own(min(rivals, key=lambda r: r.score))

    def beaten(rival: Rival) -> bool:
        # By what differs from recording to recording, and bends to much, one that holds for all is not soon beaten.
        share = policy.bending if bends and not own(rival) else policy.beaten
        return rival.score - best >= max(policy.told_apart, share * (bare - best))

    close = [r for r in rivals if not beaten(r)]
    free = min((r.score for r in close if not _at_its_end(r)), default=np.inf) + policy.told_apart
    close = [r for r in close if r.score < free or not _at_its_end(r)]
    known = any(_known(r) for r in close)

    def order(rival: Rival) -> tuple[bool, int, bool, bool, int, float]:
        effect = rival.definition
        far = known and abs(times_usual(rival)) > policy.far
        rank = 1 if effect.stage != 'sensor' else 2 if far else 0
        return own(rival), rank, turned(rival), effect.unexpected, len(effect.moved(rival.fit.muscle)), rival.score

    first = min(close, key=order)
    stage = first.definition.stage
    alike = close_rivals(rivals, bare - best, _PLAINLY if first.definition.of_muscle else 1.0)
    alike = [r for r in alike if r.definition.stage == stage and not _at_its_end(r)]
    return min([first, *alike], key=order)


def turned(rival: Rival) -> bool:
    """Whether it is physics that acts the other way round than it is known to."""
    return rival.definition.of_muscle and times_usual(rival) < 0.0


def own(rival: Rival) -> bool:
    """Whether every recording has its own strength of the effect."""
    return any(u.name.startswith(f'{rival.effect}.') and u.each_has for u in rival.fit.problem.unknowns)


def _spent(rival: Rival) -> bool:
    """Whether its strength is as far as it goes, in any recording, and that is far from what is usual: of what may
    stop a motion, all is no more than nearly all."""
    return _largest(rival) > rival.policy.far and _at_its_end(rival, f'{rival.effect}.{rival.definition.strength}')


def _at_its_end(rival: Rival, name: str = '') -> bool:
    """Whether a parameter of it (or that one) is as far as it goes, and not what it usually is there."""
    own = [u for u in rival.fit.problem.unknowns if u.name.startswith(f'{rival.effect}.') and not u.state]
    return any(_ended(rival, u) for u in own if name in ('', u.name))


def _ends(rival: Rival) -> int:
    """How many of the numbers that its form has in all recordings alike are as far as they go."""
    if rival.definition.free:
        return 0
    names = {f'{rival.effect}.{row.name}' for row in rival.definition.fitted}
    return sum(_ended(rival, u) for u in rival.fit.problem.unknowns if u.recording is None and u.name in names)


def _ended(rival: Rival, unknown: Unknown) -> bool:
    """Whether an unknown is as far as it goes, and not what it usually is there."""
    value, usual = rival.fit.values[unknown.key], rival.fit.problem.model.specifications[unknown.name].value
    return any(np.isclose(value, end, rtol=_END) and end != usual for end in (unknown.low, unknown.high))


def _known(rival: Rival) -> bool:
    """Whether it is physics about as strong as is known of the fibre."""
    return rival.definition.stage != 'sensor' and times_usual(rival) >= rival.policy.faint


def _beyond_belief(rival: Rival) -> bool:
    """Whether it is a sensor that is off as none that is in use: so far, or as its cause never makes it."""
    effect, strength = rival.definition, times_usual(rival)
    return effect.stage == 'sensor' and (abs(strength) > rival.policy.beyond_use or (effect.one_way and strength < 0.0))


def times_usual(rival: Rival) -> float:
    """Of an effect, in the strength that it usually has; of a circumstance, which has no usual sign, the size (the
    median of its recordings)."""
    strengths = _strengths(rival)
    if own(rival):
        return float(np.median(np.abs(strengths)))
    return float(abs(strengths[0]) if rival.definition.circumstance else strengths[0])


def _largest(rival: Rival) -> float:
    """The size of it in the recording that shows it most; where every recording has its own, of those that fix it."""
    return float(np.max(np.abs(_strengths(rival, fixed=True)), initial=0.0))


def _told_from(unknown: Unknown, none: float, z: float, spread: float) -> bool:
    """Whether a value (fit's coordinate, with its standard deviation) is more than one deviation away from none; by
    its logarithm, to less than a factor of e."""
    if unknown.log:
        return spread < 1.0
    return abs(z - unknown.to_fit(none)) > spread


def _strengths(rival: Rival, fixed: bool = False) -> Array:
    """In each recording (``fixed``: in those that tell it from none), or in all alike, in the strength that it usually
    has."""
    definition, fitted = rival.definition, rival.fit
    key, none = f'{rival.effect}.{definition.strength}', definition.none
    usual = fitted.problem.model.specifications[key].value - none
    mine = [(k, u) for k, u in enumerate(fitted.problem.unknowns) if u.name == key and u.recording is not None]
    if not mine:
        return np.array([(fitted.muscle[key] - none) / usual])
    if fixed:
        mine = [(k, u) for k, u in mine if _told_from(u, none, fitted.z[k], float(np.sqrt(fitted.covariance[k, k])))]
    return np.array([(u.from_fit(float(fitted.z[k])) - none) / usual for k, u in mine])
