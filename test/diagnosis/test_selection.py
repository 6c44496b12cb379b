"""What selects: who has a say among unseen data, which rival is named, how far a search goes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis.made import NOISE, NOMINAL, TIME, TRUE, experiment

from tcp_muscle_ros.diagnosis.answer.handed_on import stiffness_of_one_load
from tcp_muscle_ros.diagnosis.diagnose import _Work
from tcp_muscle_ros.diagnosis.fitting import slips
from tcp_muscle_ros.diagnosis.fitting.calibration import ages, calibrate, in_turn
from tcp_muscle_ros.diagnosis.fitting.least_squares import fit
from tcp_muscle_ros.diagnosis.fitting.weighing import calmed, settle_noise, structures
from tcp_muscle_ros.diagnosis.hypothesis.latents import Slip
from tcp_muscle_ros.diagnosis.hypothesis.work import Work
from tcp_muscle_ros.diagnosis.model.tcp_muscle import TCP_MUSCLE
from tcp_muscle_ros.diagnosis.noise.noise import quick_noise
from tcp_muscle_ros.diagnosis.search import company, rivals
from tcp_muscle_ros.diagnosis.search.candidates import Candidate, Screen, best_of, screen, variants, with_effect
from tcp_muscle_ros.diagnosis.search.companions import Companions
from tcp_muscle_ros.diagnosis.search.company import (
    alone_explains,
    beside_it,
    good_company,
    least_of_rest,
    stands_apart,
)
from tcp_muscle_ros.diagnosis.search.holdout import Gain, HeldOut, conditions, confirmation, improvement, touched
from tcp_muscle_ros.diagnosis.search.picking import Picked
from tcp_muscle_ros.diagnosis.search.refitting import rivals_for
from tcp_muscle_ros.diagnosis.search.rivals import (
    Rival,
    begins,
    follows_the_drive,
    least_drop,
    penalised,
    prefer,
    sound,
    truer,
)
from tcp_muscle_ros.diagnosis.search.selected import Chosen
from tcp_muscle_ros.diagnosis.search.selection import _has_the_steps, _Search, select
from tcp_muscle_ros.muscle import SPECIFICATIONS

CHANNELS = ('temperature', 'resistance', 'displacement')


@pytest.fixture(scope='module')
def softened():
    """A calibrated fit of recordings of a muscle whose stroke grows with its load, three loads."""
    muscle = TRUE.with_effects('load_stroke')
    runs = [experiment(CHANNELS, 0.27, load, k, muscle=muscle) for k, load in enumerate((0.3, 0.588, 0.98))]
    return settle_noise(calibrate(runs, NOMINAL).fit)[0]


def held_back(*folds):
    """Of each fold: whitened residuals on what was kept back, and on what was fitted."""
    kept, fitted = ([np.array(f[k], dtype=float) for f in folds] for k in (0, 1))
    white = tuple({'displacement': f} for f in kept)
    return HeldOut(white, tuple(fitted), tuple({'displacement': f**2} for f in kept), {}, {})


ONES, NONE = np.ones(200), np.zeros(200)


def test_a_recording_that_alone_shows_an_effect_has_no_say():
    """The first was predicted worse by far, but from the others nothing could be learnt of it."""
    before = held_back((ONES, ONES), (2.0 * ONES, ONES), (2.0 * ONES, ONES))
    after = held_back((30.0 * ONES, 1.001 * ONES), (NONE, 3.0 * ONES), (NONE, 3.0 * ONES))
    assert not improvement(before, after).holds
    gain = improvement(before, after, whole=True)
    # Beside the largest difference, though it has no say, the others are small; they are heard where they are not.
    assert gain.say == 0
    after = held_back((9.0 * ONES, 1.001 * ONES), (NONE, 3.0 * ONES), (NONE, 3.0 * ONES))
    gain = improvement(before, after, whole=True)
    assert gain.say == 2
    assert gain.holds


def test_success_beyond_what_was_fitted_confirms_and_failure_does_not_refute():
    """The models differ ten times as much in the first recording as in what they were fitted to without it."""
    others = (2.0 * ONES, ONES)
    before = held_back((4.0 * ONES, ONES), others)
    right, wrong = (held_back((first * ONES, -0.26 * ONES), (ONES, NONE)) for first in (0.0, 8.0))
    assert improvement(before, right, whole=True).say == 2
    assert improvement(before, wrong, whole=True).say == 1
    assert improvement(before, wrong, whole=True).holds
    assert improvement(before, wrong).fails


def test_who_reaches_far_and_leaves_little_was_right():
    """The models differ a hundred times as much in a recording as in what was fitted without it."""
    before = held_back((10.0 * ONES, ONES), (10.0 * ONES, ONES))
    right, half = (held_back((left * ONES, NONE), (left * ONES, NONE)) for left in (1.0, 6.0))
    assert improvement(before, right, whole=True).say == 2
    assert improvement(before, right, whole=True).holds
    assert improvement(before, half, whole=True).say == 2  # not as far
    taught, untaught = (held_back((10.0 * ONES, much * ONES), (10.0 * ONES, much * ONES)) for much in (0.8, 0.4))
    far = held_back((4.0 * ONES, NONE), (4.0 * ONES, NONE))
    assert improvement(taught, far, whole=True).say == 2
    assert improvement(untaught, far, whole=True).say == 0


def test_a_recording_unlike_the_others_does_not_refute():
    """Without the effect it is predicted far worse than the others are: that is the calibration's failure first."""
    before = held_back((9.0 * ONES, ONES), (2.0 * ONES, ONES), (2.0 * ONES, ONES))
    after = held_back((10.0 * ONES, NONE), (NONE, NONE), (NONE, NONE))
    assert improvement(before, after, whole=True).say == 2
    assert improvement(before, after, whole=True).holds


def test_where_models_hardly_differ_nothing_is_said():
    """A recording in which an effect does next to nothing may be a little worse for it."""
    before = held_back((3.0 * ONES, ONES), (ONES, ONES))
    after = held_back((NONE, 3.0 * ONES), (1.02 * ONES, 3.0 * ONES))
    assert improvement(before, after).say == 1
    assert improvement(before, after).holds


def test_a_recording_left_out_refutes_what_the_others_taught():
    before = held_back((ONES, ONES), (ONES, ONES), (ONES, ONES))
    after = held_back((2.0 * ONES, NONE), (2.0 * ONES, NONE), (NONE, NONE))
    gain = improvement(before, after, whole=True)
    assert gain.say == 3
    assert not gain.holds


def test_what_says_too_little_neither_confirms_nor_refutes():
    """The models differ enough to be heard, and the richer one is a little better: less than noise may make it."""
    before = held_back((ONES, ONES), (ONES, ONES))
    aside = np.tile([1.0, -1.0], 100)
    gain = improvement(before, held_back((0.96 * ONES - 0.2 * aside, 0.8 * ONES), (ONES, ONES)), whole=True)
    assert gain.say == 1
    assert gain.total > 0.0
    assert not gain.holds
    assert not gain.fails
    worse = improvement(before, held_back((1.2 * ONES, 0.8 * ONES), (ONES, ONES)), whole=True)
    assert worse.fails


def test_what_the_poorer_model_misses_is_no_noise_by_which_unseen_data_are_judged():
    """By it, all that a thermometer lags by is at most one noise a sample, and chance in the other channels decides."""
    muscle = TRUE.with_effects('thermocouple_lag').replace({'thermocouple_lag.tau': 2.4})
    bare = settle_noise(calibrate([experiment(CHANNELS, muscle=muscle)], NOMINAL).fit)[0]
    usual = {'thermocouple_lag.tau': SPECIFICATIONS['thermocouple_lag.tau'].value}
    problem = with_effect(bare.problem, Candidate('thermocouple_lag', usual, 0.0, 0.0))
    late = fit(problem, np.concatenate([bare.z, problem.start()[bare.z.size :]]), rounds=15)
    assert bare.problem.noise['temperature'].sigma > 10.0 * NOISE['temperature'], 'it counts as noise'
    gain, _ = confirmation(bare, late)
    assert gain.holds
    assert gain.total > 10.0 * TIME.size


def test_a_fold_that_noise_alone_could_have_tipped_has_no_voice():
    """Two of four are worse, by less than noise alone would make of such a difference."""
    before = held_back(*4 * [(2.0 * ONES, ONES)])
    hardly = 1.996 * ONES + 0.16 * np.tile([1.0, -1.0], 100)
    after = held_back((ONES, ONES), (1.8 * ONES, ONES), (hardly, ONES), (hardly, ONES))
    assert np.sum(hardly**2) > np.sum((2.0 * ONES) ** 2)
    assert improvement(before, after).say == 4
    assert improvement(before, after).folds == 1.0
    assert improvement(before, after).holds
    refuted = held_back((ONES, ONES), (1.8 * ONES, ONES), (2.3 * ONES, ONES), (2.3 * ONES, ONES))
    assert improvement(before, refuted).fails


def as_rival(fitted, effect, score, **values):
    problem = with_effect(fitted.problem, Candidate(effect, {f'{effect}.{k}': v for k, v in values.items()}, 0.0, 0.0))
    z = np.concatenate([fitted.z, problem.start()[fitted.z.size :]])
    return Rival(effect, fit(problem, z, rounds=1), score)


def test_a_sensor_goes_before_physics_unless_it_is_off_as_none_is(softened):
    physics = as_rival(softened, 'shear_softening', 1000.0, b=0.4)
    usual, far = (as_rival(softened, 'temperature_offset', 1100.0, o=o) for o in (0.8, 17.0))
    assert prefer([physics, usual], 100_000.0).effect == 'temperature_offset'
    assert prefer([physics, far], 100_000.0).effect == 'shear_softening'
    for b in (0.02, -0.4):  # a twentieth of what is known of the fibre; the other way round
        assert prefer([as_rival(softened, 'shear_softening', 1000.0, b=b), far], 100_000.0).effect == far.effect


def test_physics_that_acts_as_it_is_known_to_goes_before_one_that_acts_the_other_way_round(softened):
    known = as_rival(softened, 'shear_softening', 2000.0, b=0.4)
    turned = as_rival(softened, 'load_stroke', 1000.0, b=-0.3)
    assert prefer([known, turned], 100_000.0).effect == 'shear_softening'
    assert prefer([known, as_rival(softened, 'load_stroke', 1000.0, b=0.3)], 100_000.0).effect == 'load_stroke'
    assert prefer([known, turned], 8_000.0).effect == 'load_stroke'  # not the same: a seventh less


def test_a_sensor_that_is_off_as_none_in_use_gives_way_to_physics_that_explains_the_same(softened):
    """By 10 K, or by a stem that heats the thermometer."""
    physics = as_rival(softened, 'shear_softening', 2000.0, b=0.4)
    useless = as_rival(softened, 'temperature_offset', 1000.0, o=9.9)
    assert prefer([physics, useless], 100_000.0).effect == 'shear_softening'
    cooler, hotter = (as_rival(softened, 'thermocouple_gain', 1000.0, g=g) for g in (0.93, 1.08))
    assert prefer([physics, cooler], 100_000.0).effect == 'thermocouple_gain'
    assert prefer([physics, hotter], 100_000.0).effect == 'shear_softening'
    assert prefer([physics, hotter], 8_000.0).effect == 'thermocouple_gain'  # the same: not a seventh less
    assert prefer([as_rival(softened, 'shear_softening', 2000.0, b=0.02), hotter], 100_000.0).effect == hotter.effect


@pytest.mark.parametrize(
    ('off', 'refused'),
    [
        ([20.0, 20.0, 21.0], True),
        ([26.0, -5.0, 21.0], True),  # of rooms, and a muscle of another stiffness, to which two loads are one
        ([0.5, -14.0, 1.0], False),  # one whose cold junction failed
        ([4.0, -6.0, 3.0], False),
        ([], False),
    ],
)
def test_no_sensor_is_off_as_none_in_use_in_most_recordings(monkeypatch, softened, off, refused):
    monkeypatch.setattr(rivals, '_strengths', lambda rival, fixed=False: np.array(off))
    assert rivals._off_beyond_use(as_rival(softened, 'temperature_offset', 1000.0, o=1.0)) is refused


def test_what_begins_where_the_muscle_never_was_is_another_effect_in_disguise(softened):
    lengths = np.concatenate([o.length for o in softened.outputs])
    inside, outside = float(np.mean(lengths)), float(lengths.max() + 0.5 * np.ptp(lengths))
    assert begins(as_rival(softened, 'coil_contact', 1000.0, Hc=inside, s=0.1))
    assert not begins(as_rival(softened, 'coil_contact', 1000.0, Hc=outside, s=0.1))
    assert begins(as_rival(softened, 'creep', 1000.0, J=0.2))  # needs nothing to be crossed


def test_a_sensor_that_is_next_to_right_and_a_room_next_to_still_have_no_name(softened):
    """Less than a twentieth of what is usual; physics may be fainter, to a fiftieth."""
    for effect, usual, hardly in (
        ('temperature_offset', {'o': 0.5}, {'o': 0.005}),
        ('ambient_drift', {'a': 1.0}, {'a': 0.005}),
    ):
        assert begins(as_rival(softened, effect, 1000.0, **usual))
        assert not begins(as_rival(softened, effect, 1000.0, **hardly))
    assert begins(as_rival(softened, 'shear_softening', 1000.0, b=0.02))
    assert not begins(as_rival(softened, 'shear_softening', 1000.0, b=0.002))


def test_physics_of_a_strength_hardly_known_takes_nearly_all_that_is_left(softened):
    """What the form of a stronger effect leaves looks like that; a sensor may be off by any amount."""
    usual, faint = (as_rival(softened, 'creep', 1000.0, J=j) for j in (0.1, 0.01))
    turned = as_rival(softened, 'shear_softening', 1000.0, b=-0.3)
    sensor = as_rival(softened, 'thermocouple_lag', 1000.0, tau=0.1)
    assert [least_of_rest(rival, 0.4) for rival in (usual, sensor)] == [0.4, 0.4]
    assert [least_of_rest(rival, 0.4) for rival in (faint, turned)] == [0.85, 0.85]
    assert least_of_rest(faint, 0.9) == 0.9


def test_what_each_recording_has_by_itself_must_explain_more(softened):
    drift = {'displacement_drift.r': -2e-6}
    each = Candidate('displacement_drift', drift, 0.0, 0.0, tuple(drift for _ in softened.problem.experiments))
    problem = with_effect(softened.problem, each)
    bends = fit(problem, np.concatenate([softened.z, problem.start()[softened.z.size :]]), rounds=1)
    creep = as_rival(softened, 'creep', 4000.0, J=0.2)
    assert prefer([creep, Rival('displacement_drift', bends, 1000.0)], 100_000.0).effect == 'creep'
    assert prefer([creep, Rival('displacement_drift', bends, 1000.0)], 70_000.0).effect == 'displacement_drift'
    alike = as_rival(softened, 'displacement_drift', 1000.0, r=-2e-6)
    assert prefer([creep, alike], 100_000.0).effect == 'displacement_drift'


def test_unseen_data_are_asked_where_physics_acts_and_for_a_sensor_everywhere(softened):
    """What a sensor reads wrong, the other parameters take up."""
    assert touched(softened, as_rival(softened, 'load_stroke', 1000.0, b=0.3).fit) == {'displacement'}
    assert touched(softened, as_rival(softened, 'temperature_offset', 1000.0, o=3.0).fit) is None


def test_of_two_forms_that_are_alike_the_simpler_is_named(softened):
    flexible = as_rival(softened, 'latent_heat', 1000.0, c=0.02)
    alike, unlike = (as_rival(softened, 'radiation', score, eps=0.1) for score in (1300.0, 1500.0))
    assert prefer([flexible, alike], 11_000.0).effect == 'radiation'
    assert prefer([flexible, unlike], 11_000.0).effect == 'latent_heat'  # by odds of 4 to 1


def test_what_is_bent_as_far_as_it_goes_is_not_alike(softened):
    flexible = as_rival(softened, 'latent_heat', 1000.0, c=0.02)
    for eps, named in ((0.1, 'radiation'), (SPECIFICATIONS['radiation.eps'].high, 'latent_heat')):
        problem = with_effect(softened.problem, Candidate('radiation', {'radiation.eps': eps}, 0.0, 0.0))
        fitted = fit(problem, np.concatenate([softened.z, problem.start()[softened.z.size :]]), rounds=0)
        assert prefer([flexible, Rival('radiation', fitted, 1300.0)], 11_000.0).effect == named


def test_what_samples_do_not_resolve_is_late_by_nothing(softened):
    """One each fifth of a second: a core that follows within a twentieth of one is none."""
    lags, follows = (as_rival(softened, 'two_node', 1000.0, f=0.4, G=g) for g in (0.2, 1.2))
    assert begins(lags)
    assert not sound(follows)
    assert sound(as_rival(softened, 'supply_lag', 1000.0, tau=0.5))
    assert not sound(as_rival(softened, 'supply_lag', 1000.0, tau=0.05))
    assert not sound(as_rival(softened, 'thermocouple_lag', 1000.0, tau=0.05))
    assert sound(as_rival(softened, 'clock_skew', 1000.0, d=0.05, channel=1.0))  # two channels show it at once


def test_a_clock_is_resolved_no_better_than_a_lag_where_one_channel_was_seen():
    fitted = settle_noise(calibrate([experiment(('displacement',), seed=k) for k in range(2)], NOMINAL).fit)[0]
    for late, resolved in ((0.05, False), (0.15, True)):
        assert sound(as_rival(fitted, 'supply_lag', 1000.0, tau=late)) == resolved
        assert sound(as_rival(fitted, 'clock_skew', 1000.0, d=late, channel=1.0)) == resolved


def test_what_is_read_more_often_for_a_while_resolves_as_much_there():
    """Every second at first and every two later, as from a film: a delay of 0.6 s is resolved."""
    (run,) = [experiment(('displacement',))]
    every = np.array([k for k in range(0, 1050, 5) if k < 300 or k % 10 == 0])
    run = replace(run, observed={'displacement': run.observed['displacement'].only(np.isin(np.arange(1050), every))})
    fitted = calibrate([run], NOMINAL).fit
    assert sound(as_rival(fitted, 'supply_lag', 1000.0, tau=0.6))
    assert not sound(as_rival(fitted, 'supply_lag', 1000.0, tau=0.3))


def test_a_trace_of_physics_must_be_plain(softened):
    """A drop that chance does not give is enough for what is as strong as it is known to be."""
    least = softened.problem.policy.least_drop
    known, trace = (as_rival(softened, 'shear_softening', 1000.0, b=b) for b in (0.4, 0.02))
    assert least_drop(known) == least
    assert least_drop(trace) == 10.0 * least


@pytest.mark.parametrize(
    ('effect', 'values', 'channels', 'apart'),
    [
        ('contact_shorting', {'s': 0.2}, CHANNELS, True),
        ('contact_shorting', {'s': 0.2}, ('temperature', 'displacement'), False),
        ('latent_heat', {'c': 0.05}, ('resistance', 'displacement'), True),
        ('latent_heat', {'c': 0.05}, ('displacement',), False),
    ],
)
def test_an_effect_stands_apart_where_a_channel_shows_its_stage(effect, values, channels, apart):
    """Elsewhere it is one more way to bend what a form leaves, and takes nearly all of it or is none."""
    shown = as_rival(calibrate([experiment(channels)], NOMINAL).fit, effect, 1000.0, **values)
    assert stands_apart(effect, shown.fit, ['hysteresis', effect]) is apart
    assert least_of_rest(shown, 0.4) == (0.4 if apart else 0.85)


def test_what_has_to_be_crossed_is_tried_where_the_muscle_has_been():
    spans = {'length': (0.12, 0.16), 'fibre_temperature': (296.0, 340.0)}
    contacts = {values['coil_contact.Hc'] for values in variants(TCP_MUSCLE, 'coil_contact', 210.0, spans)}
    assert sum(0.12 < contact < 0.16 for contact in contacts) >= 4
    kinks = {values['cte_kink.Tg'] for values in variants(TCP_MUSCLE, 'cte_kink', 210.0, spans)}
    assert max(kinks) - min(kinks) > 0.6 * 44.0


def test_a_companion_takes_most_of_what_is_left(softened):
    ranked, _ = screen(softened, ['load_stroke', 'friction', 'creep'])
    named = rivals_for(softened, ranked, None)[0]
    assert named.effect == 'load_stroke'
    assert good_company(softened, softened, named.fit, 0.65, softened.problem.policy.of_all)
    ranked, _ = screen(named.fit, ['friction', 'creep'])
    for rival in rivals_for(named.fit, ranked, None):
        assert not good_company(softened, named.fit, rival.fit, 0.65, softened.problem.policy.of_all)


def test_one_that_explains_the_rest_alone_may_be_little_beside_a_stronger_one():
    """A creep beside a stroke that changes much with the load: some hundredths of what was missed, and no form leaves
    what one effect alone explains. Where another explains nearly as much, it may be the form's."""
    muscle = TRUE.replace({'creep.J': 0.03, 'load_stroke.b': 3.0}).with_effects('load_stroke', 'creep')
    runs = [experiment(CHANNELS, 0.27, load, k, muscle=muscle) for k, load in enumerate((0.3, 0.588, 0.98))]
    bare = settle_noise(in_turn(calibrate(runs, NOMINAL).fit))[0]
    without = rivals_for(bare, screen(bare, ['load_stroke'])[0], None)[0].fit
    found = rivals_for(without, screen(without, ['creep', 'two_node', 'hysteresis'])[0], None)
    assert found[0].effect == 'creep'
    policy = bare.problem.policy
    assert not good_company(bare, without, found[0].fit, policy.of_rest, policy.of_all)
    others = beside_it('creep', found, penalised(without))
    assert len(others) == len(found) - 1 and all(other < 0.65 for other in others)
    assert alone_explains(bare, without, found[0].fit, found[0], others)
    assert not alone_explains(bare, without, found[0].fit, found[0], [*others, 0.7])


def test_what_stands_beside_a_simpler_form_is_sought_beside_the_one_that_fits_best(softened):
    """Of two that explain the same to a hundredth the simpler is named, and the other is the truer form."""
    ranked, _ = screen(softened, ['load_stroke'])
    best = rivals_for(softened, ranked, None)[0]
    drop = penalised(softened) - best.score
    simple = replace(best, effect='shear_softening', score=best.score + 0.01 * drop)
    assert truer([best, simple], 'shear_softening', drop) is best
    assert truer([best, simple], 'load_stroke', drop) is None
    beaten = replace(simple, score=best.score + 0.5 * drop)
    assert truer([best, beaten], 'shear_softening', drop) is None


@pytest.mark.parametrize(('loads', 'law'), [((0.588, 0.588), 0.0), ((0.3, 0.98), 1.0)])
def test_what_rubs_is_told_by_other_loads_and_else_the_usual(loads, law):
    """Under one load a pulley and a guide are the same; which it is comes from no recording then."""
    pulley = TRUE.replace({'friction.Ff': 0.04, 'friction.law': 1.0}).with_effects('friction')
    runs = [experiment(CHANNELS, 0.27, load, k, muscle=pulley) for k, load in enumerate(loads)]
    bare = settle_noise(calibrate(runs, NOMINAL).fit)[0]
    best = rivals_for(bare, screen(bare, ['friction'])[0], None)[0]
    assert best.fit.muscle['friction.law'] == law
    if law:
        assert best.fit.muscle['friction.Ff'] == pytest.approx(0.04, rel=0.1)


def test_the_simpler_form_gives_way_only_where_something_stands_beside_the_truer(softened, monkeypatch):
    search = _Search(softened, None, ['load_stroke', 'shear_softening', 'creep'], None, 4)
    ranked, _ = screen(softened, ['load_stroke'])
    best = rivals_for(softened, ranked, None)[0]
    drop = penalised(softened) - best.score
    simple = replace(best, effect='shear_softening', score=best.score + 0.01 * drop)
    contest = (drop, [best, simple])
    search.accepted, search.contests = ['shear_softening'], {'shear_softening': contest}
    before = search.present, search.structure
    nothing, creep = Picked(None, (0.0, []), (), {}), Picked(replace(best, effect='creep'), (1.0, []), (), {})
    asked = []

    def picked(present, structure, pool, *_):
        asked.append((present.problem.parameters.effects, pool))
        return answer

    monkeypatch.setattr('tcp_muscle_ros.diagnosis.search.selection.pick', picked)
    answer = nothing
    assert search._beside_a_truer_form(['load_stroke', 'creep']) is None
    assert asked == [(('load_stroke',), ['creep'])]
    assert (search.present, search.structure) == before
    assert search.accepted == ['shear_softening'] and search.contests == {'shear_softening': contest}
    answer = creep
    assert search._beside_a_truer_form(['load_stroke', 'creep']) is creep
    assert search.accepted == ['load_stroke'] and search.contests == {'load_stroke': contest}
    assert search.present.problem.parameters.effects == ('load_stroke',)
    work = search.present.problem.work
    monkeypatch.setattr(work, 'steps', 0.6 * work.limit)  # nothing would be held against it
    assert search._beside_a_truer_form(['creep']) is None


def test_what_a_swing_leaves_does_not_drown_the_rest():
    """Samples in which a weight swings, fifty times as far off as the noise, weigh a fiftieth once that is known."""
    run = experiment(CHANNELS)
    o, swinging = run.observed['displacement'], np.mod(TIME, 70.0) < 40.0
    wild = o.value + np.where(swinging, 50 * 5e-5 * np.sin(20.0 * TIME) * 2**0.5, 0.0)
    swung = replace(run, observed={**run.observed, 'displacement': replace(o, value=wild, swinging=swinging)})
    before = calibrate([swung], NOMINAL).fit
    after = calmed(before, before)
    weight = after.problem.weight('displacement', 0)
    assert np.all(weight[~swinging] == 1.0)
    assert 1 / 60 < weight[swinging].max() < 1 / 20
    assert after.mean_square['displacement'] < 0.02 * before.mean_square['displacement']
    assert np.all(before.problem.weight('temperature', 0) == 1.0)
    for noise in (quick_noise([swung]), quick_noise([run])):  # half of all bends may be the swing's
        assert 4e-5 < noise['displacement'].sigma < 6e-5
    still = before.left[0]['displacement'][~swinging]
    assert before.still_square['displacement'] == pytest.approx(np.mean(still**2))


def test_fatigue_goes_on_from_one_recording_to_the_next():
    """Each recording is 3 cycles; begun anew, the later ones would lose stroke as the first does."""
    runs = []
    for k, current in enumerate((0.27, 0.27, 0.24)):
        muscle = TRUE.replace({'fatigue.c': 0.03, 'fatigue.n0': 2.6 * k}).with_effects('fatigue')
        runs.append(experiment(CHANNELS, current, 0.588, k, muscle=muscle))
    fitted = in_turn(settle_noise(calibrate(runs, NOMINAL).fit)[0])
    cycles = [latent.before.cycles for latent in fitted.problem.latents]
    assert cycles[0] == 0.0
    assert 2.0 < cycles[1] < 4.0
    assert cycles[2] == pytest.approx(2.0 * cycles[1], rel=0.05)
    ranked, _ = screen(fitted, ['fatigue', 'creep', 'viscous_flow', 'friction'])
    assert ranked[0].effect == 'fatigue'
    best = rivals_for(fitted, ranked, None)[0]
    assert best.effect == 'fatigue'
    assert best.fit.muscle['fatigue.c'] == pytest.approx(0.03, rel=0.25)
    assert conditions(fitted.problem)
    after = ages((*fitted.problem.experiments, runs[0]), fitted.outputs)[-1]
    assert after.cycles == pytest.approx(cycles[2] + cycles[1], rel=0.25)  # the third is less hot
    assert after.used == pytest.approx(3.0 * runs[0].duration)


@pytest.mark.parametrize(('wear', 'counts'), [(0.0027, True), (0.0012, False)])
def test_an_effect_counts_from_a_tenth_of_the_noises_variance_on(wear, counts):
    """Slow as it is, it is clear by then: some hundred readings agree on it."""
    worn = [TRUE.replace({'fatigue.c': wear, 'fatigue.n0': 2.6 * k}).with_effects('fatigue') for k in range(3)]
    runs = [experiment(CHANNELS, 0.27, 0.588, k, muscle=muscle) for k, muscle in enumerate(worn)]
    before = in_turn(settle_noise(calibrate(runs, NOMINAL).fit)[0])
    ranked, _ = screen(before, ['fatigue'])
    after = rivals_for(before, ranked, None)[0].fit
    noise = structures(after)['displacement'].noise
    drop = before.mean_square['displacement'] - after.mean_square['displacement']
    assert 0.02 < drop / noise.sigma**2 < 0.25
    assert good_company(before, before, after, 0.65, before.problem.policy.of_all) == counts


def test_a_search_that_has_spent_its_budget_ends_with_what_it_has(softened):
    spent = replace(softened, problem=replace(softened.problem, work=Work(0.0)))
    assert select(spent, ['load_stroke', 'friction']).chosen == ()
    assert not spent.problem.work.left
    found = select(replace(softened, problem=replace(softened.problem, work=Work())), ['load_stroke', 'friction'])
    assert [c.effect for c in found.chosen] == ['load_stroke']
    assert found.final.problem.work.steps > TIME.size * 3 * 20


@pytest.mark.parametrize(
    ('effect', 'values', 'currents'),
    [
        pytest.param('resistance_strain', {'GF': 1.0}, (0.27, 0.2), marks=pytest.mark.long),
        ('contact_shorting', {'s': 0.25, 'Hc': 0.125, 'w': 0.002}, (0.27, 0.27)),
    ],
)
def test_what_the_muscle_became_without_an_effect_does_not_hold_its_fit_back(effect, values, currents):
    true = {f'{effect}.{name}': value for name, value in values.items()}
    muscle = TRUE.with_effects(effect).replace(true)
    runs = [
        experiment(CHANNELS, current, load, k, muscle=muscle)
        for k, (current, load) in enumerate(zip(currents, (0.3, 0.588), strict=True))
    ]
    bare = settle_noise(calibrate(runs, NOMINAL).fit)[0]
    found = rivals_for(bare, [best_of(Screen.of(bare).candidates(effect), 2.0)], None)[0].score
    best = penalised(fit(with_effect(bare.problem, Candidate(effect, true, 0.0, 0.0))))
    assert found < best + 0.01 * (penalised(bare) - best)


@pytest.mark.parametrize(('left', 'has'), [(0.05, True), (0.07, False)])
def test_what_a_law_explains_nearly_all_of_did_not_leap(softened, left, has):
    leapt = slips.added(
        softened,
        [[Slip('resistance', run.imposed.time[0] + 30.0, 0.5, 0.01, 0.1)] for run in softened.problem.experiments],
    )
    squares = dict.fromkeys(CHANNELS, 1.0)
    found = SimpleNamespace(
        chosen=('a law',),
        calibrated=SimpleNamespace(mean_square=squares),
        final=SimpleNamespace(mean_square={**squares, 'resistance': left}),
    )
    assert _has_the_steps(found, leapt) == has
    assert not _has_the_steps(SimpleNamespace(**{**vars(found), 'chosen': ()}), leapt)


@pytest.mark.long
def test_what_a_companion_leaves_nothing_to_explain_stood_in_its_place():
    """A lag is the simpler name for a delay that it nearly follows. Beside it, whatever its form may miss, the delay is
    found; with the delay there is no lag."""
    late = TRUE.with_effects('clock_skew').replace({'clock_skew.d': 0.4})
    switching = np.where(np.mod(TIME, 5.0) < 2.25, 0.27, 0.03)
    runs = [
        experiment(CHANNELS[:2], seed=1, muscle=late),
        experiment(CHANNELS[:2], seed=2, drive=switching, muscle=late),
    ]
    (chosen,) = select(calibrate(runs, NOMINAL).fit, ['thermocouple_lag', 'clock_skew']).chosen
    assert chosen.effect == 'clock_skew'
    assert chosen.indistinguishable == ()


@pytest.mark.parametrize(('begins_at', 'alike'), [((31.0, 31.4, 30.8), True), ((31.0, 47.0, 30.8), False)])
def test_a_draught_that_begins_equally_long_after_each_switch_is_none(softened, begins_at, alike):
    switch = float(softened.problem.experiments[0].imposed.time[np.flatnonzero(
        np.diff(softened.problem.experiments[0].imposed.drive))[0] + 1])  # fmt: skip
    own = tuple({'airflow.g': 0.5, 'airflow.t1': at, 'airflow.d': 10.0} for at in begins_at)
    problem = with_effect(softened.problem, Candidate('airflow', own[0], 0.0, 0.0, own))
    added = problem.unknowns[softened.z.size :]
    z = np.concatenate([softened.z, [u.to_fit(u.start) for u in added]])
    rival = Rival('airflow', replace(softened, problem=problem, z=z), 0.0)
    assert switch < min(begins_at)
    assert follows_the_drive(rival) == alike


@pytest.mark.long
def test_what_the_data_admit_in_the_place_of_a_named_effect_is_not_named_beside_it(monkeypatch):
    """Radiation, which these recordings hardly tell from moisture that dries: its form leaves some of that."""
    muscle = TRUE.with_effects('radiation')
    runs = [experiment(CHANNELS, current, 0.5, k, muscle=muscle) for k, current in enumerate((0.2, 0.24, 0.27))]
    bare = settle_noise(calibrate(runs, NOMINAL).fit)[0]
    search = _Search(bare, None, ['radiation', 'moisture', 'natural_convection'], None, 3)
    search.forward()
    search.revise()
    assert search.accepted == ['radiation']
    beside = rivals_for(search.present, screen(search.present, ['moisture'])[0], None)[0]

    def brings(*_):
        gain = search.standing['radiation']
        return Companions(beside.fit, {'moisture': (9.0, [beside])}, {'moisture': gain}, True)

    monkeypatch.setattr('tcp_muscle_ros.diagnosis.search.selection.companions', brings)
    search.add_companions()
    assert search.accepted == ['radiation']


def test_what_stays_for_want_of_a_confirmed_rival_is_among_its_rivals(monkeypatch):
    """Where its numbers are at their bounds it is none; whether it stays is said at last, and how likely it is then."""
    late = TRUE.with_effects('hysteresis')
    runs = [experiment(CHANNELS, current, seed=k, muscle=late) for k, current in enumerate((0.27, 0.22))]
    bare = settle_noise(calibrate(runs, NOMINAL).fit)[0]
    present = rivals_for(bare, screen(bare, ['hysteresis'])[0], None)[0].fit
    monkeypatch.setattr(company, 'sound', lambda rival: rival.effect != 'hysteresis')
    monkeypatch.setattr(company, 'confirmation', lambda *_: (Gain(0.0, 0.0, 0.0, 0.0, 0.0), ()))
    _, accepted, contests = company.revise(present, ['hysteresis'], ['hysteresis', 'friction', 'two_node'], {}, None)
    drop, rivals = contests['hysteresis']
    assert accepted == ['hysteresis'] and len(rivals) > 1
    assert [r.score for r in rivals] == sorted(r.score for r in rivals)
    assert 0.0 < Chosen('hysteresis', drop, Gain(0, 0, 0, 0, 0), 1.0, tuple(rivals)).confidence <= 1.0


@pytest.mark.parametrize(('limit', 'finds', 'counts'), [(0.0, ('creep',), False), (10.0, (), False),
                                                        (10.0, ('creep',), True), (1e9, (), True)])  # fmt: skip
def test_a_second_search_that_the_work_ran_out_under_does_not_take_the_place_of_the_first(
    monkeypatch, limit, finds, counts
):
    first, spent = SimpleNamespace(), Work(limit)
    again = SimpleNamespace(final=None, chosen=[SimpleNamespace(effect=e) for e in finds])
    made = _Work((experiment(CHANNELS),), NOMINAL, None, ())
    made.calibration = SimpleNamespace(fit=SimpleNamespace(problem=SimpleNamespace(work=spent)))

    def selected(*_):
        spent.add(20.0)
        return again

    monkeypatch.setattr(made, '_selected', selected)
    monkeypatch.setattr('tcp_muscle_ros.diagnosis.diagnose.wandered', lambda _: 0.0)
    assert made._where_rooms_wander(first, []) is (again if counts else first)
    assert made.wandering == counts


def test_where_nothing_is_found_no_stiffness_is_pulled_to_what_was_assumed(softened):
    """It is when effects bend it; a fit that only has other numbers as assumed has none."""
    assert stiffness_of_one_load(replace(softened), softened) is None
