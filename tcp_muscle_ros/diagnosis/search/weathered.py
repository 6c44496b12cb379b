"""A draught, or a room that drifts, that goes its own way in every recording, where no law explains what is left.

One gust or a cubic describes little of it, so that it loses every contest of forms. It is named by the evidence of a
course (``fitting/weather.py``): where that takes as much of what is left as a law without a name must, the channels
agree on it (of a stroke a hundredth of a kelvin makes much, and so does mechanics), and the state of the muscle does
not foretell it, as it would a law. What it hid is sought beside it then.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace

from tcp_muscle_ros.diagnosis.fitting import draught, slips
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.weather import Course, as_read, courses, evidence_of, left_by
from tcp_muscle_ros.diagnosis.fitting.weighing import settle_noise, structures
from tcp_muscle_ros.diagnosis.search.companions import allowing_for, companions, stand_ins
from tcp_muscle_ros.diagnosis.search.company import good_company, least_of_all
from tcp_muscle_ros.diagnosis.search.free_laws import HALF, LAST, excess, less
from tcp_muscle_ros.diagnosis.search.holdout import Gain, held_out, stretches
from tcp_muscle_ros.diagnosis.search.refitting import one_for_each, shrink
from tcp_muscle_ros.diagnosis.search.remaining import unexplained
from tcp_muscle_ros.diagnosis.search.rivals import Rival, penalised
from tcp_muscle_ros.diagnosis.search.selected import Chosen, Selection

_LAW = 0.2  # of a course (squared): more that the state foretells is a law's
_SURE = 10.0  # least drops
_AS_MUCH = 0.998  # of the evidence: what explains less is not as likely (a supply explains all that the air would)
_PLAINLY_LESS = 0.7  # of what a supply leaves: the courses of the air follow an unsteady supply to within a sixth


def with_weather(found: Selection, effects: Sequence[str], progress: Callable[[], None] | None = None) -> Selection:
    """The selection with a draught or a room that drifts, and what it hid, where its course explains what is left; else
    as it is."""
    inferred = found.final.problem.model.roles.inferred & set(effects)
    if not inferred or {c.effect for c in found.chosen} & inferred:
        return found
    sudden = found.leapt is not None or slips.slipping(found.final)
    if sudden or not found.final.problem.work.within(LAST):
        return found
    if found.chosen and unexplained(found.told) is None:  # what is left is the form of what is named
        return found
    begun = _without_heat_laws(found)
    base = begun.final
    likely = _of_the_air(base, inferred)
    if not likely or not _plain(likely, _SURE * base.problem.policy.least_drop):
        return found
    named = _named(begun, base, likely, progress)
    return found if named is None else _looked_at(_with_what_it_hid(named, likely[0].effect, effects, progress))


def _without_heat_laws(found: Selection) -> Selection:
    """The selection without laws of heat that have no name: where they are of the muscle, its state foretells them."""
    for chosen in found.chosen:
        if chosen.definition.free is not None and chosen.definition.stage == 'thermal':
            final, kept = less(found, chosen)
            found = replace(found, final=final, chosen=kept, unnamed=None)
    return found


def _named(
    found: Selection, base: Fit, likely: Sequence[Course], progress: Callable[[], None] | None
) -> Selection | None:
    """The selection with the likeliest course on top of a fit; None where it does not take what is left after all."""
    rivals = _described(base, likely, progress)
    if not rivals or rivals[0].effect != likely[0].effect:
        return None
    followed = settle_noise(draught.with_course(rivals[0].fit), 1)[0]
    if excess(followed, found) > HALF * excess(base, found):
        return None
    if found.chosen and not good_company(found.calibrated, base, followed, HALF, least_of_all(rivals[0])):
        return None
    return _with(found, rivals, likely[0], followed, _less_noise(found, base, likely[0]))


def _of_the_air(base: Fit, inferred: Collection[str]) -> list[Course]:
    """The courses of a draught and a room, the likelier first; none where an unsteady supply explains as much.

    Of a misfit that is many times the noise both explain nearly all: then what they leave tells which of them it is.
    """
    likely = courses(base)
    air = [course for course in likely if course.effect in inferred]
    supply = max((course.evidence for course in likely if not course.effect), default=0.0)
    if not air or supply <= _AS_MUCH * air[0].evidence:
        return air
    return air if left_by(base, air[0].effect) < _PLAINLY_LESS * left_by(base, '') else []


def _plain(likely: Sequence[Course], sure: float) -> bool:
    """Whether the likeliest is there, takes enough, and is no law, in whichever way that is as likely it is told: a
    draught told as a room is foretold in part, for it takes the more heat the hotter the muscle is."""
    first = likely[0]
    no_law = all(course.foretold < _LAW for course in likely if course.evidence >= _AS_MUCH * first.evidence)
    return min(first.evidence, first.witnessed) > sure and first.share > HALF and no_law


def _described(base: Fit, likely: Sequence[Course], progress: Callable[[], None] | None) -> list[Rival]:
    """The fits with one gust, or a cubic, in every recording; each as good as the evidence of its course says."""
    bare = penalised(base)
    fits = [one_for_each(base, course.effect, progress) for course in likely]
    return [replace(r, score=bare - course.evidence) for r, course in zip(fits, likely, strict=True) if r is not None]


def _with(found: Selection, rivals: Sequence[Rival], course: Course, followed: Fit, less_noise: float) -> Selection:
    """The selection that has it; ``less_noise`` scales its evidence to the drops of what was named before."""
    final = rivals[0].fit
    drop, bare = less_noise * course.evidence, rivals[0].score + course.evidence
    scored = tuple(replace(r, score=bare - less_noise * (bare - r.score)) for r in rivals)
    gain = Gain(course.witnessed, 0.0, 0.0, 1.0, len(final.problem.experiments))
    share = 1.0 - excess(followed, found) / max(excess(found.calibrated, found), 1e-300)
    return _ending(replace(found, chosen=(*found.chosen, Chosen(course.effect, drop, gain, share, scored))), final)


def _less_noise(found: Selection, base: Fit, course: Course) -> float:
    """The scale of the drops of what was named before, which are under the noise of their fits, beside the evidence of
    a course, which is under that of the instruments: the drop of the strongest over what it adds to the course under
    the latter; 1 where that is less, or nothing."""
    strongest = max(found.chosen, key=lambda c: c.drop, default=None)
    if strongest is None:
        return 1.0
    both = as_read(base)
    alone = shrink(both, strongest.effect)
    adds = penalised(alone) - penalised(both) + course.evidence - evidence_of(alone, course.effect)
    return strongest.drop / adds if adds > strongest.drop else 1.0


def _with_what_it_hid(
    found: Selection, weather: str, effects: Sequence[str], progress: Callable[[], None] | None
) -> Selection:
    """The selection with what stands beside it, and without what stood in its place."""
    others = [c.effect for c in found.chosen if c.effect != weather]
    instead, without = stand_ins(allowing_for(found.final, (weather,)), others)
    if instead:
        kept = tuple(c for c in found.chosen if c.effect not in instead)
        found = _ending(replace(found, chosen=kept, unnamed=None), allowing_for(without, ()))
    model, accepted = found.final.problem.model, [c.effect for c in found.chosen]
    pool = [e for e in effects if e not in accepted and e not in model.roles.inferred and e != model.roles.swings]
    most = int(found.final.problem.policy.most_effects)
    beside = companions(found.final, accepted, pool, found.calibrated, most, progress)
    if not beside.contests:
        return found
    more = [Chosen(e, drop, *beside.standing[e], tuple(rivals)) for e, (drop, rivals) in beside.contests.items()]
    found = _ending(replace(found, chosen=(*found.chosen, *more)), beside.fit)
    base = shrink(found.final, weather)  # which of the two it is, they may have hidden
    likely = [course for course in courses(base) if course.effect in effects]
    if likely[0].effect == weather:
        return found
    kept = tuple(c for c in found.chosen if c.effect != weather)
    return _named(replace(found, chosen=kept), base, likely, progress) or found


def _ending(found: Selection, final: Fit) -> Selection:
    """The selection that ends with this fit."""
    final = settle_noise(final, 1)[0]
    chosen = tuple(sorted(found.chosen, key=lambda c: -c.drop))
    return replace(found, final=final, chosen=chosen, structure_after=structures(final))


def _looked_at(found: Selection) -> Selection:
    """The selection with what unseen data say. What each recording has for itself, only other stretches of it tell."""
    kept_back = stretches(found.final.problem)
    before, after = held_out(found.calibrated, kept_back), held_out(found.final, kept_back)
    return replace(found, before=before, after=after, other_conditions=False, kept_back=kept_back)
