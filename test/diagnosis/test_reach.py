"""A law without a name at currents and loads that nobody recorded: within the range, and a fifth beyond it.

The muscles are integrated by the truth generator, which knows nothing of the simulator's laws.
"""

import numpy as np
import pytest
from diagnosis.made import NOMINAL
from diagnosis.written import as_read, recorded
from scipy.interpolate import CubicSpline

from proof.reach import LEFT, PLACES, missed
from proof.written import Written, case_of, unseen
from tcp_muscle_ros.commands.domain import Domain
from tcp_muscle_ros.diagnosis.answer.handed_on import handed_on
from tcp_muscle_ros.diagnosis.fitting.calibration import calibrate, in_turn
from tcp_muscle_ros.diagnosis.search.free_laws import with_free_law
from tcp_muscle_ros.diagnosis.search.selection import select
from tcp_muscle_ros.muscle.edges import inside
from tcp_muscle_ros.settings.parameter_file import read, write

LISTED = ['natural_convection', 'radiation', 'exposed_area', 'heat_capacity', 'friction']
# Of a form that no listed effect has: the hotter, the less heat is carried off. Not so much that the muscle burns with
# a fifth more current.
LAWS = {'free_conductance': Written('square', 'loss', 0.0, -0.12)}


@pytest.fixture(scope='module', params=list(LAWS))
def handed(request, tmp_path_factory):
    """The law, the muscles by how they were made, and what each misses, by place."""
    folder, effect = tmp_path_factory.mktemp('reach'), request.param
    case = case_of(LAWS[effect], 5)
    listed = select(in_turn(calibrate(recorded(case, folder), NOMINAL).fit), LISTED)
    found = with_free_law(listed)
    muscles = {}
    for way, muscle in (
        ('recalibration', listed.calibrated.muscle),
        ('listed', handed_on(listed)[0]),
        ('improved', handed_on(found)[0]),
    ):
        path = folder / f'{way}.yaml'
        write(path, muscle)
        muscles[way] = read(str(path)).parameters
    further = unseen(case.lab, case.rng(900)).items()
    runs = {place: as_read(case, 10 + k, experiment, folder) for k, (place, experiment) in enumerate(further)}
    misses = {way: missed(case, runs, muscle) for way, muscle in muscles.items()}
    return effect, muscles, runs, misses


def closed(misses, way, place):
    """The share of the gap between the recalibrated muscle and the noise."""
    before, after = (misses[name][place][0] for name in ('recalibration', way))
    return (before - after) / (before - LEFT)


@pytest.mark.slow
def test_within_the_range_it_predicts_and_beyond_it_is_not_worse_than_recalibration(handed):
    effect, muscles, _, misses = handed
    assert effect in muscles['improved'].effects
    for place in PLACES:
        assert misses['recalibration'][place][0] > LEFT, 'there is a gap'
        assert misses['improved'][place][0] < misses['recalibration'][place][0], place
        assert closed(misses, 'improved', place) > closed(misses, 'listed', place), place
    for place in ('within', 'load'):  # a load beyond the range is no temperature beyond it
        assert closed(misses, 'improved', place) > 0.85, place


@pytest.mark.slow
def test_beyond_its_table_it_goes_on_in_a_straight_line_and_says_so(handed):
    """A knot far beyond, on that line, changes nothing but that the table reaches there."""
    effect, muscles, runs, misses = handed
    improved = muscles['improved']
    at, value = (np.array(improved.column(f'{effect}.{name}')) for name in ('at', 'value'))
    assert misses['improved']['within'][1] == 0.0
    for place in ('current', 'both'):
        assert misses['improved'][place][1] > 0.05, 'outside its table for part of the time'
        outputs = runs[place].outputs(improved)
        assert outputs.fibre_temperature.max() > at[-1] + 5.0
        domain = Domain(improved['H0'])
        domain.look(outputs)
        assert any('a free law is used beyond its table, where it is extended in a' in note for note in domain.notes())
        far = 400.0  # K
        last = value[-1] + CubicSpline(at, value, bc_type='natural')(at[-1], 1) * (far - at[-1])
        table = {f'{effect}.at': (*map(float, at), far), f'{effect}.value': (*map(float, value), float(last))}
        longer = improved.replace(inside(table))
        straight = runs[place].outputs(longer)
        assert straight.fibre_temperature == pytest.approx(outputs.fibre_temperature, abs=1e-4)
        assert straight.length == pytest.approx(outputs.length, abs=1e-7)
        assert straight.in_domain.all()
