"""Company: what an effect is worth beside the others, whether something else could take its place, and what unseen data
say of it then."""

from collections.abc import Callable, Iterator, Mapping, Sequence

from tcp_muscle_ros.diagnosis.fitting.generic import Structure
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weighing import robust_noise, settle_noise, structures
from tcp_muscle_ros.diagnosis.search.candidates import screen
from tcp_muscle_ros.diagnosis.search.holdout import Fold, Gain, conditions, confirmation, stretches
from tcp_muscle_ros.diagnosis.search.refitting import one_for_all, rivals_for, shrink
from tcp_muscle_ros.diagnosis.search.rivals import (
    Rival,
    begins,
    least_drop,
    margin,
    own,
    penalised,
    prefer,
    sound,
    times_usual,
    truer,
    turned,
)

_REVISED = 3  # rivals that an effect must hold against
_MANY = 36  # unknowns: beyond, a refit takes many times as long, and what could replace an effect is tried once
# Of what is left, an effect that none comes near takes so much that it may be less of what was missed.
_MOST, _LITTLE, _NEAR = 0.7, 0.001, 0.65
_LEAST_APART = 0.08  # of what an effect beside others takes of all at least, where an effect stands apart
_TRIFLE = 0.1  # of the noise's variance: what a companion of a stronger effect must take away at least
_REAL = 0.05  # of a channel's squared error: a drop that needs no further sign of being real
_FORETOLD = 0.6  # of what a circumstance explains: what physics explains and foretells at least, in whose place it is
_ASKED = 3  # of such physics, that unseen data are asked of
_BENDING = 2.0  # times the usual share: what each recording has for itself bends to what any form leaves

Contest = tuple[float, list[Rival]]  # the drop of the misfit that the best of these rivals brings


def share(before: dict[str, Structure], fitted: Fit, after: Fit) -> float:
    """The largest share, over channels, of the misfit above noise that went.

    The noise is that of the better model where it is the smaller, and no more than that leaves: what a model lacks may
    look like noise to it.
    """
    shares = []
    left = structures(after)
    for name, s in before.items():
        a = fitted.mean_square[name]
        b = after.mean_square[name]
        gap = a - min(s.noise.sigma**2, left[name].noise.sigma ** 2, b)
        if (s.significant or a - b > _REAL * a) and gap > 0.0:
            shares.append((a - b) / gap)
    return max(shares, default=0.0)


def good_company(calibrated: Fit, without: Fit, fitted: Fit, rest: float, of_all: float, apart: bool = False) -> bool:
    """Whether an effect beside a stronger one is more than what the stronger one's form leaves.

    It takes a share ``of_all`` of what was missed, and a share ``rest`` of what is left: what a form leaves, several
    effects explain a little, and none of them all. One that stands ``apart`` may be the less of what was missed, the
    more it takes of what is left.
    """
    policy = fitted.problem.policy
    took = largest_share(without, without, fitted, robust=False)
    least = of_all
    if apart:
        least *= max(_LEAST_APART, min(1.0, (1.0 - took) / (1.0 - policy.of_rest_at_first)))
    return took >= rest and largest_share(calibrated, without, fitted) >= least


def alone_explains(calibrated: Fit, without: Fit, fitted: Fit, rival: Rival, others: Sequence[float]) -> bool:
    """Whether an effect stands alone and takes most of what is left: then it may be little beside a stronger one."""
    alone = stands_alone(rival, others)
    return alone and good_company(calibrated, without, fitted, least_of_rest(rival, _MOST), _LITTLE)


def stands_alone(rival: Rival, others: Sequence[float]) -> bool:
    """Whether none of the ``others`` (shares of the drop that an effect brings) explains nearly as much, and it does
    not bend: what a form misses, several explain."""
    return not bends(rival) and all(other < _NEAR for other in others)


def beside_it(effect: str, rivals: Sequence[Rival], bare: float) -> list[float]:
    """What each of the others explains of what an effect does; ``bare``: the score without any."""
    drop = max((bare - r.score for r in rivals if r.effect == effect), default=0.0)
    return [(bare - r.score) / drop if drop > 0.0 else 1.0 for r in rivals if r.effect != effect]


def bends(rival: Rival) -> bool:
    """Whether it bends to what any form misses: what differs from recording to recording, and physics the other way
    round than it is known."""
    return rival.definition.circumstance or turned(rival)


def foretelling(bare: Fit, chosen: Rival, rivals: Sequence[Rival]) -> Rival:
    """The physics that foretells recordings that it was not fitted to, where ``chosen`` is not to be named beside it.

    A course that each recording has for itself is not, beside one law for all that explains most of the same: no law
    foretells what came by chance. (A mere offset a law may follow by chance, where there are few recordings.) Nor is
    what a mere trace of physics plainly beats: what it explains is no trace.
    """
    drop = penalised(bare) - chosen.score
    most = _FORETOLD * drop
    able = [r for r in rivals if r is not chosen and r.definition.of_muscle]
    if _own_course(chosen):
        able = [r for r in able if penalised(bare) - r.score >= most]
    else:
        able = [r for r in able if not begins(r) and chosen.score - r.score >= margin(drop, r.policy)]
    for rival in sorted(filter(sound, able), key=lambda r: r.score)[:_ASKED]:
        gain, _ = confirmation(bare, rival.fit)
        if gain.holds and gain.total >= most:
            return chosen if _alike_each_time(bare, chosen, rival) else rival
    return chosen


def _alike_each_time(bare: Fit, chosen: Rival, law: Rival) -> bool:
    """Whether it is the course of a sensor of which one for all recordings foretells, too, and explains more than the
    law; or as much, where the law plainly misses the course. What warms up may do so alike each time."""
    policy, without = chosen.policy, penalised(bare)
    shared = one_for_all(bare, chosen.effect) if _own_course(chosen) and chosen.definition.stage == 'sensor' else None
    if shared is None or not begins(shared):
        return False
    missed = law.score - chosen.score >= margin(without - chosen.score, policy)
    best = min(shared.score, law.score)
    least = margin(without - best, policy) if missed else -policy.told_apart
    return shared.score - law.score < least and confirmation(bare, shared.fit)[0].holds


def in_place_of(chosen: Rival, instead: Rival, rivals: Sequence[Rival]) -> list[Rival]:
    """The rivals of what is named instead of another, itself first: circumstances that foretell nothing are none."""
    others = [r for r in rivals if r.effect != instead.effect]
    return [instead, *(r for r in others if not (_own_course(chosen) and own(r)))]


def _itself(effect: str, fitted: Fit) -> Rival:
    """An effect of a fit as its rivals are."""
    return Rival(effect, fitted, penalised(fitted))


def disguised(fitted: Fit, accepted: Sequence[str]) -> bool:
    """Whether one of the effects of a fit is another in disguise, as it may turn out to be when fitted to the end."""
    return not all(sound(_itself(effect, fitted)) for effect in accepted)


def _own_course(rival: Rival) -> bool:
    """Whether it goes another way in every recording."""
    return own(rival) and bool(rival.definition.whole or rival.definition.moments)


def least_of_all(rival: Rival) -> float:
    """Of what was missed, what an effect must take beside a stronger one."""
    return rival.policy.of_all * (_BENDING if own(rival) else 1.0)


def least_of_rest(rival: Rival, usually: float) -> float:
    """Of what is left, what an effect must take beside others: ``usually``, or nearly all where it is physics of a
    strength that is hardly known of the fibre, or of a stage that no channel shows, as what forms leave looks like."""
    physics = rival.definition.stage != 'sensor'
    hardly = times_usual(rival) < rival.policy.faint_beside or not _shown(rival.effect, rival.fit)
    return max(usually, rival.policy.nearly_all) if physics and hardly else usually


def _shown(effect: str, fitted: Fit) -> bool:
    """Whether a recorded channel shows the stage of an effect, other than by what follows from it."""
    model = fitted.problem.model
    shown_by = model.shown_by.get(model.effects[effect].stage)
    return shown_by is None or any(shown_by & set(e.observed) for e in fitted.problem.experiments)


def stands_apart(effect: str, fitted: Fit, accepted: Sequence[str]) -> bool:
    """Whether it is physics of a stage of which nothing was found yet: what a form leaves, effects of its own stage
    explain best, and of a stage that no channel shows any does. Circumstances bend to anything, what is left of a swing
    to much, and any form's rest looks like some physics that is fainter than is known of the fibre."""
    effects = fitted.problem.model.effects
    found = {effects[other].stage for other in accepted if other != effect}
    definition = effects[effect]
    if (
        definition.stage in found | {'sensor'}
        or definition.circumstance
        or fitted.problem.model.roles.swings in accepted
    ):
        return False
    return _shown(effect, fitted) and times_usual(Rival(effect, fitted, 0.0)) >= fitted.problem.policy.faint_beside


def largest_share(missing: Fit, without: Fit, fitted: Fit, robust: bool = True) -> float:
    """The largest share, over channels, of what one model misses, that an effect takes away from another.

    Channels count in which it takes away something beside the noise; ``robust`` counts what it leaves as noise. Beside
    a swing, which is far larger than all else, what is missed while nothing swings.
    """
    shares = []
    missed_of, left_of, leaves = _missed(missing, without, fitted)
    found = structures(fitted)
    noises = robust_noise(fitted, found) if robust else {name: s.noise for name, s in found.items()}
    for name, noise in noises.items():
        missed = missed_of[name] - noise.sigma**2
        drop = left_of[name] - leaves[name]
        if missed > 0.0 and drop > _TRIFLE * noise.sigma**2:
            shares.append(drop / missed)
    return max(shares, default=0.0)


def beyond_form(calibrated: Fit, without: Fit, fitted: Fit) -> bool:
    """Whether an effect takes away more, in a channel, than the forms of the others may miss of what those explain
    there: twice the standard deviation of that."""
    may_miss = (2.0 * fitted.problem.policy.form) ** 2
    missed_of, left_of, leaves = _missed(calibrated, without, fitted)
    return any(
        left_of[name] - leaves[name] > max(may_miss * (missed_of[name] - left_of[name]), _TRIFLE * s.noise.sigma**2)
        for name, s in structures(fitted).items()
    )


def _missed(missing: Fit, without: Fit, fitted: Fit) -> list[Mapping[str, float]]:
    """The mean square error of each by channel; beside a swing, while nothing swings."""
    swings = without.problem.model.roles.swings in without.problem.parameters.effects
    return [model.still_square if swings else model.mean_square for model in (missing, without, fitted)]


def revise(
    present: Fit,
    accepted: list[str],
    effects: Sequence[str],
    first: Mapping[str, Contest],
    progress: Callable[[], None] | None,
) -> tuple[Fit, list[str], dict[str, Contest]]:
    """Swap and prune: each effect must beat, in the company of the others, whatever could replace it. What is another
    in disguise is replaced by whatever can.

    ``first``: the contests in which they were accepted; who came close then is tried again.
    """
    contests = dict(first)
    for _ in range(2 if len(present.problem.unknowns) <= _MANY else 1):
        changed = False
        for effect in list(accepted):
            if not present.problem.work.left:
                break
            # What a swing leaves of itself weighs little, and hides what it took: all of it was asked for at first.
            if effect == present.problem.model.roles.swings:
                continue
            bare = shrink(present, effect)
            known = [r.effect for r in first[effect][1]] if effect in first else []
            pool = [e for e in dict.fromkeys((*effects, *known)) if e == effect or e not in accepted]
            ranked, _signals = screen(bare, pool, progress)
            most = _REVISED if len(bare.problem.unknowns) <= _MANY else 1
            found = rivals_for(bare, ranked, progress, most, known)
            rivals, itself = [r for r in found if r.effect != effect and begins(r)], _itself(effect, present)
            if rivals and not sound(itself):
                found = [r for r in found if r.effect != effect]
            else:
                rivals.append(itself)
            rivals.sort(key=lambda r: r.score)
            drop = penalised(bare) - min(r.score for r in rivals)
            if drop < present.problem.policy.least_drop:
                present, changed = bare, True
                accepted.remove(effect)
                contests.pop(effect, None)
                continue
            pick = prefer(rivals, penalised(bare))
            instead = foretelling(bare, pick, found)
            if instead is not pick:
                pick, rivals = instead, in_place_of(pick, instead, rivals)
            plain = penalised(bare) - pick.score >= least_drop(pick)
            if pick.effect != effect and not (plain and confirmation(bare, pick.fit)[0].holds):
                pick = itself  # that one was confirmed, when it was accepted
                if not any(r.effect == effect for r in rivals):  # though unsound: whether it stays, ``confirm`` says
                    rivals = sorted([*rivals, itself], key=lambda r: r.score)
            if pick.effect != effect:
                present, changed = pick.fit, True
                accepted[accepted.index(effect)] = pick.effect
                contests.pop(effect, None)
            contests[pick.effect] = (drop, rivals)
        if not changed or len(accepted) < 2:
            break
    return present, accepted, contests


def _beside_each_form(
    effect: str, bare: Fit, present: Fit, accepted: Sequence[str], contests: Mapping[str, Contest]
) -> Iterator[tuple[Fit, Fit]]:
    """The fits without an effect and with it: beside the others as they are named, and with the form in the place of
    one of them that fits best, where it is not named for not being the simplest."""
    yield bare, present
    having = set(present.problem.parameters.effects)
    for other in accepted:
        drop, rivals = contests[other]
        if other in (effect, present.problem.model.roles.swings) or not present.problem.work.left:
            continue
        instead = truer(rivals, other, drop)
        if instead is None or instead.effect == effect:
            continue
        # Contests may be older than what is accepted now.
        if set(instead.fit.problem.parameters.effects) == having - {other} | {instead.effect}:
            yield shrink(instead.fit, effect), instead.fit


def _fits_in(calibrated: Fit, without: Fit, having: Fit, rival: Rival, contest: Contest, apart: bool) -> bool:
    """Whether an effect is good company for the others: by what it takes of what is left, and of all."""
    (drop, rivals), policy = contest, rival.policy
    rest = policy.of_rest_at_first if beyond_form(calibrated, without, having) else policy.of_rest
    if good_company(calibrated, without, having, rest, least_of_all(rival), apart=apart):
        return True
    alike = beside_it(rival.effect, rivals, min(r.score for r in rivals) + drop)
    return alone_explains(calibrated, without, having, rival, alike)


def confirm(
    present: Fit, accepted: list[str], contests: dict[str, Contest], calibrated: Fit, alone: bool = True
) -> tuple[Fit, list[str], dict[str, tuple[Gain, float]], tuple[Fold, ...]]:
    """Each effect once more on unseen data, in the company of the others: without it they must be predicted worse.

    The strongest need be no good company, unless they are not ``alone``. Returns what was kept back too: other
    conditions if they could speak for every effect, else stretches.
    """
    standing: dict[str, tuple[Gain, float]] = {}
    other_conditions = bool(conditions(present.problem))
    strongest = max(accepted, key=lambda e: contests[e][0], default='') if alone else ''
    for effect in sorted(accepted, key=lambda e: contests[e][0]):
        bare, rival = shrink(present, effect), _itself(effect, present)
        gain, looked_at = confirmation(bare, present)
        swings = effect == present.problem.model.roles.swings  # unseen data confirmed it when it was picked, see above
        holds = swings or gain.holds
        apart = stands_apart(effect, present, accepted)
        fits_in = (
            swings
            or effect == strongest
            or any(
                _fits_in(calibrated, without, having, rival, contests[effect], apart)
                for without, having in _beside_each_form(effect, bare, present, accepted, contests)
            )
        )
        trace = any(r.effect == effect and not begins(r) for r in contests[effect][1])  # and foretold all the same
        if holds and fits_in and (sound(rival) if trace else begins(rival)):
            standing[effect] = gain, largest_share(calibrated, bare, present)
            other_conditions &= looked_at[0].whole is not None
        else:
            # What is left without it is the noise by which the next is judged.
            present = settle_noise(bare, 1)[0]
            accepted = [e for e in accepted if e != effect]
    kept_back = (conditions(present.problem) if other_conditions else ()) or stretches(present.problem)
    return present, accepted, standing, kept_back
