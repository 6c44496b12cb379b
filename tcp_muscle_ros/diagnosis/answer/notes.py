"""What is to be known beside the findings: slips, leaps, rests, stops, what was not tried or not seen, and the age."""

from collections.abc import Mapping, Sequence

import numpy as np

from tcp_muscle_ros.diagnosis.answer.findings import RunToRun
from tcp_muscle_ros.diagnosis.answer.in_words import driver_of
from tcp_muscle_ros.diagnosis.answer.repeating import notes_on_runs
from tcp_muscle_ros.diagnosis.answer.sentences import amount, quantity, words
from tcp_muscle_ros.diagnosis.answer.sticking import Rests, mostly, said_of
from tcp_muscle_ros.diagnosis.fitting import draught
from tcp_muscle_ros.diagnosis.fitting.anchored import anchored
from tcp_muscle_ros.diagnosis.fitting.least_squares import Fit
from tcp_muscle_ros.diagnosis.fitting.stick_slip import CHANCE, STOP
from tcp_muscle_ros.diagnosis.fitting.warm_start import warm_at_the_start
from tcp_muscle_ros.diagnosis.observation.closed_loop import is_closed_loop
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment, one_load
from tcp_muscle_ros.diagnosis.observation.stopping import stops
from tcp_muscle_ros.diagnosis.search.location import Unexplained
from tcp_muscle_ros.diagnosis.search.remaining import wandering
from tcp_muscle_ros.diagnosis.search.selected import Selection
from tcp_muscle_ros.diagnosis.search.shared import shared_misfit
from tcp_muscle_ros.muscle import EFFECTS, ZERO_CELSIUS, Parameters
from tcp_muscle_ros.settings.ages import Age


def every_note(
    selection: Selection,
    remains: Unexplained | None,
    untried: Mapping[str, str],
    runs: RunToRun | None,
    rests: Rests,
) -> tuple[str, ...]:
    """What is to be known beside the findings."""
    return (
        *notes_on_runs(runs),
        *on_unrepeated(remains, runs),
        *on_untried(selection, untried),
        *on_kind(selection.final.problem.followed),
        *on_one_load(selection.final.problem.followed),
        *on_unanchored(selection.best),
        *on_bent_form(selection),
        *on_warm_start(selection.final),
        *on_draught(selection),
        *on_leads(selection),
        *on_doubtful(selection),
        *on_slips(selection),
        *on_rests(rests),
        *on_stops(selection.final.problem.followed),
        *on_shared(selection, remains),
        *on_unseen(selection),
        *on_cut_short(selection),
    )


def on_kind(experiments: Sequence[Experiment]) -> tuple[str, ...]:
    """What the kind of recording costs: no thermometer, one recording, a drive that follows the muscle."""
    seen, channels = {name for e in experiments for name in e.observed}, experiments[0].model.channels
    found = [channel.without for name, channel in channels.items() if channel.without and name not in seen]
    if len(experiments) < 3:
        few = 'a single recording: the unseen data are parts of it' if len(experiments) == 1 else ''
        found.append(f'{few or "two recordings: the unseen data are parts of them"}; no other condition was tested')
    if any(is_closed_loop(e) for e in experiments):
        found.append(
            'the drive follows the muscle (closed loop): the controller corrects an error of the stroke by the '
            'current, so creep, hysteresis and a loss of stroke are hard to see; record open-loop steps'
        )
    return tuple(found)


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
    what = 'the end slipped suddenly' if selection.leapt is None else 'a reading changed suddenly and stayed changed'
    better = 'has their mean rate' if selection.leapt is None else 'does not contain them'
    return (
        f'{what}: {"; ".join(each)}; no model predicts these instants, so they are taken from the recordings, also '
        f'from held-out ones; improved.yaml {better}',
    )


def on_untried(selection: Selection, untried: Mapping[str, str]) -> tuple[str, ...]:
    """That no listed effect was tried, and why, where it is so of all for one reason; ``untried``: the reasons."""
    whys, listed = set(untried.values()), set(selection.final.problem.model.listed)
    return (f'no listed effect was tried: {whys.pop()}',) if len(whys) == 1 and listed <= set(untried) else ()


def on_leads(selection: Selection) -> tuple[str, ...]:
    """Which effects came nearest, where they explain too little to be named."""
    if not selection.leads:
        return ()
    names, one = ' and '.join(words(name) for name in selection.leads), len(selection.leads) == 1
    comes, leaves, its, is_ = ('comes', 'leaves', 'its', 'it is') if one else ('come', 'leave', 'their', 'they are')
    return (
        f'{names} {comes} nearest to what is unexplained, but {leaves} more of it than {its} form may miss: '
        f'{is_} not named',
    )


def on_doubtful(selection: Selection) -> tuple[str, ...]:
    """Which effects were found beside those named, and are not named."""
    return tuple(
        f'{words(d.effect)} was found too, but not surely enough (probability {d.probability:.2f}): it is not named'
        for d in selection.doubtful
    )


def on_unanchored(fitted: Fit) -> tuple[str, ...]:
    """That the recordings do not say how hot the muscle became, where they do not, and what improved.yaml makes of it.

    It may hardly warm there, and still pass through a stroke."""
    if anchored(fitted):
        return ()
    model = fitted.problem.model
    hottest = max(float(np.max(getattr(outputs, model.state))) for outputs in fitted.outputs)
    return (
        f'the recordings do not fix {model.loss}, so nobody knows how hot the muscle became: improved.yaml has it at '
        f'{hottest - ZERO_CELSIUS:.0f} degC at most, one of many temperatures that fit; it foretells the '
        f'{quantity(model.motion)} and no temperature, and no drive may be called safe by it',
    )


def on_bent_form(selection: Selection) -> tuple[str, ...]:
    """That a listed form was bent, by what, over what, and where it is found."""
    if selection.bent is None:
        return ()
    (law,) = set(selection.bent.muscle.effects) - set(selection.final.muscle.effects)
    driver, stage = words(driver_of(selection.bent, law)), EFFECTS[law].stage
    names = [words(c.effect) for c in selection.chosen if c.definition.stage == stage]
    return (
        f'the listed form of {" and ".join(names)} is not quite that of this muscle: improved.yaml has a table over '
        f'the {driver} beside it ({law}), which also predicts unseen data better',
    )


def on_warm_start(fitted: Fit) -> tuple[str, ...]:
    """Which recordings begin while the muscle is warm, where that had to be inferred."""
    return tuple(
        f'recording {k + 1} begins while the muscle is warm, at {start - ZERO_CELSIUS:.0f} degC: no thermometer shows '
        'it, it was found from what follows'
        for k, start in warm_at_the_start(fitted).items()
    )


def on_one_load(experiments: Sequence[Experiment]) -> tuple[str, ...]:
    """That one load hung in all recordings, where they show the motion: it tells stiffness and stroke together only."""
    if not any(e.model.motion in e.observed for e in experiments) or not one_load(experiments):
        return ()
    return (
        'one and the same load hung in all recordings: they do not tell the stiffness from the stroke, so a prediction '
        'under another load is uncertain; one recording under another load would tell',
    )


def on_draught(selection: Selection) -> tuple[str, ...]:
    """How far a draught went beside the gusts by which it is named, or a room beside its cubic, and what became of
    it."""
    followed = selection.followed
    if followed is None:
        return ()
    roles = followed.problem.model.roles
    if roles.course not in {c.effect for c in selection.chosen}:
        return (
            f'the room went its own way: beside one smooth course in each recording it was off by '
            f'{draught.size(followed):.2g} K (root mean square); improved.yaml has the muscle in the room that its '
            f'thermometer shows',
        )
    varied = max(draught.strength(followed))
    return (
        f'the draught came and went: beside one gust in each recording the loss of heat varied by '
        f'{100.0 * varied:.0f} % (root mean square); improved.yaml has the muscle in air that moves as on average',
    )


def on_unrepeated(unexplained: Unexplained | None, runs: RunToRun | None) -> tuple[str, ...]:
    """That nothing says how much of what is ``unexplained`` any model could predict, where no runs repeat each other:
    it may as well differ from run to run."""
    if unexplained is None or runs is not None:
        return ()
    return (
        'how well such recordings can be predicted at all is unknown, since none of them repeats another: a second run '
        'of the same protocol tells',
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


def on_rests(rests_and_jumps: Rests) -> tuple[str, ...]:
    """In which recordings a channel rests and jumps where the model moves, and where a contraction stops short."""
    said = []
    seen = rests_and_jumps.seen
    for channel in dict.fromkeys(name for _, name, _ in seen):
        mine = [(e, s) for e, name, s in seen if name == channel]
        found = [s for _, s in mine if s.kind == CHANCE]
        if found:
            rests = np.concatenate([s.durations() for s in found])
            jumps = np.concatenate([s.sizes() for s in found])
            low, high = (amount(channel, size) for size in mostly(jumps))
            short, long = mostly(rests)
            like = said_of(rests_and_jumps.like) if channel == mine[0][0].model.motion else ''
            said.append(
                f'the {quantity(channel)} sticks and slips in {len(found)} of {len(mine)} recordings: {rests.size} '
                f'rests, mostly of {short:.1f} to {long:.1f} s, and {jumps.size} jumps both ways, mostly of {low} to '
                f'{high}; their instants are chance, so no model predicts them (effect: stick_slip){like}'
            )
        said += [
            f'{e.name}: the {quantity(channel)} stops changing while the simulation goes on: a mechanical stop, such '
            f'as coils in contact, a rail or a string'
            for e, s in mine
            if s.kind == STOP and not stop_of(e)
        ]
    return tuple(said)


def on_stops(experiments: Sequence[Experiment]) -> tuple[str, ...]:
    """Which contractions end against something, and how far each has come: seen in the recording itself, for a model
    bends to it."""
    found = _stops(experiments)
    if not found:
        return ()
    channel = experiments[0].model.motion
    shown = experiments[0].model.channels[channel]
    each = ', '.join(
        f'{name} at {at * shown.factor:.3g} {shown.unit} from {first:.1f} to {last:.1f} s'
        for name, (first, last, at) in found.items()
    )
    return (
        f'the {quantity(channel)} ends against a stop, such as coils in contact, a rail or a string: {each}; it came '
        f'there without slowing down and then stayed while the heating went on, so a model fitted to these recordings '
        f'bends to the stop',
    )


def led_by_stops(experiments: Sequence[Experiment]) -> str:
    """The stop against which contractions end, as the sentence that comes first: what else is said may come of it. ''
    where there is none."""
    found = _stops(experiments)
    if not found:
        return ''
    channel = experiments[0].model.motion
    shown = experiments[0].model.channels[channel]
    ends = [at * shown.factor for _, _, at in found.values()]
    low, high = f'{min(ends):.3g}', f'{max(ends):.3g}'
    where = f'at {low} {shown.unit}' if low == high else f'at {low} to {high} {shown.unit}'
    which = f' in {len(found)} of {len(experiments)} recordings' if len(experiments) > 1 else ''
    return (
        f'The {quantity(channel)} ends against a stop {where}{which}, such as coils in contact, a rail or a string; '
        f'a fitted model bends to it, so what else is said may come of it.'
    )


def _stops(experiments: Sequence[Experiment]) -> dict[str, tuple[float, float, float]]:
    return {e.name: stop for e in experiments if (stop := stop_of(e))}


def stop_of(experiment: Experiment) -> tuple[float, float, float] | None:
    """The stop at which the motion in a recording ends: from when to when (s from its start), and where (m)."""
    o, drive = experiment.observed.get(experiment.model.motion), experiment.imposed
    begin = float(drive.time[0])
    for first, last, at in stops(o.time, o.value, drive.time, drive.drive) if o is not None else ():
        return first - begin, last - begin, at
    return None


def on_age(now: Parameters, ages: Sequence[Age]) -> tuple[str, ...]:
    """How old the muscle is now, where it ages."""
    first = ages[0].values if ages else {}
    return tuple(
        f'{name} was {before:.4g} before the first recording and is {now[name]:.4g} after the last: improved.yaml has '
        f'the value after the last, and a replay of these recordings uses the value of each'
        for name, before in first.items()
    )


def on_unseen(selection: Selection) -> tuple[str, ...]:
    """That stretches were held out where recordings might have been."""
    if selection.other_conditions or len(selection.final.problem.experiments) < 3:
        return ()
    return (
        'the unseen data are parts of the recordings; no other condition was tested, because what was found cannot be '
        'learnt from the other recordings alone',
    )


def on_cut_short(selection: Selection) -> tuple[str, ...]:
    """That more might have been tried."""
    if selection.final.problem.work.left:
        return ()
    return ('the search was cut short: with fewer or shorter recordings at once more could be tried',)
