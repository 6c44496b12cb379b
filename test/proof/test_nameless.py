"""What counts as said of physics that no catalogue holds, and that the cases hold it."""

import json

import pytest

from proof.answers import Answer
from proof.cases import EXPRESSIBLE, PHYSICS, make_case
from proof.nameless import (
    ALONE,
    BESIDE,
    CONTINUOUS,
    LISTED,
    OLD,
    OTHERS,
    Group,
    both_told,
    closed,
    document,
    in_stage,
    wanted,
)
from proof.nameless import said_unlisted as said


def answer(truth, findings, unexplained=None, missed=None):
    """``truth`` and ``findings``: (effect, stage); ``missed``: by way, in noises."""
    visible = {'detectable': True, 'peak': {'temperature': 9.0}}
    label = {
        'kind': 'unlisted',
        'what': truth[-1][0],
        'effects': [{'effect': name, 'stage': stage, 'visibility': visible} for name, stage in truth],
        'noise': {'temperature': 0.1},
    }
    report = {
        'verdict': 'missing_physics',
        'findings': [
            {'effect': name, 'stage': stage, 'unlisted': {} if not name.startswith('free_') else {'driver': 'force'}}
            for name, stage in findings
        ],
        'unexplained': unexplained and {'stage': unexplained},
    }
    limits = {way: {'temperature': 0.1 * size} for way, size in (missed or {}).items()}
    return Answer(label, report, limits.get('diagnosis'), limits)


def test_every_form_comes_as_often_as_any_other_and_each_case_has_what_it_says():
    alone = [what for kind, what in wanted(ALONE, 120, 23) if kind == 'unlisted']
    assert {alone.count(name) for name in (*OLD, *EXPRESSIBLE)} == {5, 6}
    assert len(OLD) == 17 and len(EXPRESSIBLE) == 6 and set(EXPRESSIBLE) <= set(CONTINUOUS)
    for number, (kind, what) in enumerate(wanted(BESIDE, 4, 23)):
        assert [c.effect for c in make_case('varied', 23, number, kind, what).concealed] == what.split('+')
        listed, other = what.split('+')
        assert listed in PHYSICS and other in CONTINUOUS
    assert {what for _, what in wanted(LISTED, 60, 23)} == set(PHYSICS)


def test_a_law_without_a_name_and_what_is_left_unexplained_both_say_that_something_has_none():
    bump = [('gelling_resin', 'mechanical')]
    free, listed = ('free_stiffness', 'mechanical'), ('cte_kink', 'mechanical')
    assert said(answer(bump, [free])) and in_stage(answer(bump, [free])) and not answer(bump, [free]).physics
    assert said(answer(bump, [], 'mechanical')) and in_stage(answer(bump, [], 'mechanical'))
    assert not in_stage(answer(bump, [('free_conductance', 'thermal')]))
    assert not said(answer(bump, [listed])) and answer(bump, [listed]).physics
    # The stage that counts is that of the effect without a name.
    pair = [('radiation', 'thermal'), *bump]
    assert not in_stage(answer(pair, [('radiation', 'thermal')], 'thermal'))


@pytest.mark.parametrize(
    ('findings', 'told'),
    [
        (['radiation', 'free_stiffness'], True),
        (['radiation'], False),
        (['free_stiffness'], False),
        (['moisture', 'free_stiffness'], False),
        (['radiation', 'cte_kink', 'free_stiffness'], False),
    ],
)
def test_beside_a_listed_effect_that_one_is_named_alone_and_the_rest_has_no_name(findings, told):
    pair = [('radiation', 'thermal'), ('gelling_resin', 'mechanical')]
    assert both_told(answer(pair, [(name, 'mechanical') for name in findings])) is told


def test_the_gap_lies_between_the_recalibrated_muscle_and_the_noise():
    bump = [('gelling_resin', 'mechanical')]
    missed = {'recalibration': 5.0, 'whiteness_bic': 4.0, 'diagnosis': 2.0}
    one = answer(bump, [('free_stiffness', 'mechanical')], missed=missed)
    assert closed(one, 'diagnosis') == pytest.approx(0.75)
    assert closed(one, 'whiteness_bic') == pytest.approx(0.25)
    assert closed(answer(bump, [], missed=missed | {'recalibration': 1.2}), 'diagnosis') is None
    text = document({ALONE: [one], BESIDE: [], LISTED: []}, 23)
    assert '| an unlisted effect is flagged | 90 % | 1/1' in text
    assert '| diagnosis | 0.75 | 0.75 | 1 |' in text
    assert '| gelling_resin | 1 | 1 | 1 | 0 | free_stiffness |' in text


def test_what_failed_is_counted_and_only_what_was_not_tried_is_left_out(tmp_path):
    """Of four cases: all done, the diagnosis failed, a method beside it failed, and nothing done yet."""
    group = Group(tmp_path, ALONE, 4, 1, 2)
    done = answer([('gelling_resin', 'mechanical')], [('free_stiffness', 'mechanical')])
    names = [f'case_{k:04d}' for k in range(4)]
    failed = {('diagnosis', names[1]), ('whiteness_bic', names[2])}
    for name in names:
        (group.proof.bags / name).mkdir(parents=True)
        for way in ('diagnosis', *OTHERS) if name != names[3] else ():
            folder = group.proof.reports / way / name
            folder.mkdir(parents=True)
            if (way, name) in failed:
                (folder / 'failed').write_text('ValueError: no')
            else:
                (folder / 'report.json').write_text(json.dumps(done.report))
                (folder / 'held_out.json').write_text(json.dumps({'temperature': 0.5 if way in OTHERS else 0.1}))
    group.proof.labels.write_text(json.dumps({'cases': [done.label | {'case': name} for name in names]}))
    answers = group.answers()
    assert [said(a) for a in answers] == [True, False, True]
    assert [closed(a, 'diagnosis') for a in answers] == pytest.approx([1.0, 0.0, 1.0])
    text = document({ALONE: answers, BESIDE: [], LISTED: []}, 23)
    assert '| an unlisted effect is flagged | 90 % | 2/3' in text
    assert '| a listed name is given instead | at most 25 % | 0/2' in text
