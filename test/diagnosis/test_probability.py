"""The probability of a finding: made from terms that the policy weighs; and that of a verdict that names something."""

from dataclasses import replace

import pytest
from diagnosis.made import NOMINAL, TRUE, experiment
from diagnosis.test_sentences import FINDING

from tcp_muscle_ros.diagnosis.answer.probability import NAMELESS, TERMS, of_verdict, probability
from tcp_muscle_ros.diagnosis.diagnose import diagnose
from tcp_muscle_ros.settings.policy import shipped

NEUTRAL = dict.fromkeys(TERMS, 0.0) | {'constant': 1.0, 'among_rivals': 2.0, 'not_nothing': 2.0}


def test_the_policy_weighs_every_term_and_every_verdict_that_names_nothing():
    assert list(shipped().odds) == [*TERMS, *NAMELESS]


@pytest.mark.parametrize('against', ['at_bound', 'circumstance', 'sensor', 'others', 'few', 'left'])
def test_what_speaks_against_a_finding_makes_it_less_probable(against):
    weights = shipped().odds
    assert probability(NEUTRAL | {against: 1.0}, weights) < probability(NEUTRAL, weights)


@pytest.mark.parametrize('favours', ['among_rivals', 'not_nothing', 'drop'])
def test_what_speaks_for_a_finding_makes_it_more_probable(favours):
    weights = shipped().odds
    assert probability(NEUTRAL | {favours: 2.3}, weights) > probability(NEUTRAL | {favours: -1.0}, weights)


def test_a_verdict_is_as_probable_as_that_one_of_its_findings_is_there():
    two = [replace(FINDING, probability=0.8), replace(FINDING, probability=0.5)]
    weights = shipped().odds
    assert of_verdict('missing_physics', two, weights) == pytest.approx(0.9)
    sensor = replace(FINDING, stage='sensor', probability=0.3)
    assert of_verdict('missing_physics', [*two, sensor], weights) == pytest.approx(0.9)
    assert of_verdict('sensor_or_setup', [sensor], weights) == pytest.approx(0.3)


def test_a_verdict_that_names_nothing_is_as_probable_as_it_proved_right():
    weights = shipped().odds | {'match': 0.0, 'unexplained': 2.0}
    assert of_verdict('match', [], weights) == 0.5
    assert of_verdict('unexplained', [], weights) == pytest.approx(0.881, abs=1e-3)
    assert of_verdict('insufficient_data', [], weights) is None and of_verdict('not_repeatable', [], weights) is None


@pytest.mark.long
def test_a_diagnosis_says_what_each_probability_is_made_from():
    muscle = TRUE.replace({'radiation.eps': 0.9}).with_effects('radiation')
    runs = [
        experiment(('temperature', 'resistance', 'displacement'), current, 0.588, k, muscle=muscle)
        for k, current in enumerate((0.27, 0.2, 0.24))
    ]
    found = diagnose(runs, NOMINAL)
    for finding in found.findings:
        assert set(finding.evidence) == set(TERMS)
        assert finding.probability == pytest.approx(probability(finding.evidence, shipped().odds))
    assert found.findings and found.verdict_probability == of_verdict(found.verdict, found.findings, shipped().odds)
