"""Suites: reproducible from their seed, bags that are readable, labels that are sealed, scores that are right."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from rosbags.highlevel import AnyReader

from proof.answers import read
from proof.cases import BASE, FULL, PHYSICS, SUITES, composition, make_case, signals_of
from proof.extend import as_experiment, extend
from proof.generate import generate, write_case, write_recording
from proof.recordings import INPUTS, Noise
from proof.truth import EFFECTS, observe
from proof.visibility import Refit, stack, visibility
from tcp_muscle_ros.recording.bag import read_bag

CASES = 4
OUTPUTS = ('temperature', 'resistance', 'displacement', 'force')
TOPICS = {f'/{name}' for name in (*OUTPUTS, 'load', 'current', 'power', 'voltage')}


@pytest.fixture(scope='module')
def suite(tmp_path_factory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp('suite')
    directory, labels = folder / 'cases', folder / 'labels.json'
    generate('development', CASES, 4, directory, labels, jobs=1)
    return directory, labels


def test_the_full_suite_has_what_was_promised():
    wanted = composition('sealed', 0, 7)
    kinds = [kind for kind, _ in wanted]
    assert {kind: kinds.count(kind) for kind in FULL} == FULL
    assert sum(FULL.values()) >= 400
    assert {what for kind, what in wanted if kind == 'single'} == set(PHYSICS)


@pytest.mark.parametrize('cases', [1, 7, 40, 399])
def test_a_smaller_suite_has_as_many_cases_as_asked_for(cases):
    assert len(composition('development', cases, 1)) == cases


def test_a_suite_can_be_of_some_kinds_alone():
    wanted = composition('varied', 30, 1, ('triple', 'double'))
    kinds = [kind for kind, _ in wanted]
    assert (kinds.count('double'), kinds.count('triple'), len(kinds)) == (23, 7, 30)  # as 60 and 20 in the full suite


def test_a_logger_shows_an_input_at_its_own_samples_alone(tmp_path):
    case = make_case('development', 5, 0, 'null', '')
    write_case(case, tmp_path / 'whole')
    write_case(case, tmp_path / 'logged', every=0.3)
    drive = INPUTS[case.experiments[0].kind]
    whole, logged = (read_bag(tmp_path / name / case.name / 'recording_0')[drive] for name in ('whole', 'logged'))
    np.testing.assert_allclose(np.diff(logged.time[1:]), 0.3, atol=0.01)  # stamps jitter
    at = np.searchsorted(whole.time, logged.time + 1e-6, side='right') - 1
    np.testing.assert_array_equal(logged.value, whole.value[at])


def test_the_suites_differ_in_seeds_and_in_forms():
    cases = [make_case(suite, 1, 0, 'single', 'creep') for suite in SUITES]
    assert len({case.concealed[0].form for case in cases}) == len(SUITES)
    assert len({case.lab.body for case in cases}) == len(SUITES)
    unlisted = [{what for kind, what in composition(suite, 0, 1) if kind == 'unlisted'} for suite in SUITES]
    assert not set.intersection(*unlisted)


@pytest.mark.parametrize(('suite', 'form'), [('varied', 2), ('outside', 3)])
def test_every_kind_of_case_can_be_drawn_with_third_and_fourth_forms(suite, form):
    for number, (kind, what) in enumerate(dict(composition(suite, 0, 2)).items()):
        case = make_case(suite, 2, number, kind, what)
        assert case.form == form
        forms = [EFFECTS[hidden.effect].forms for hidden in case.concealed]
        assert [hidden.form for hidden in case.concealed] == [names[form % len(names)] for names in forms]
    case = make_case(suite, 2, 0, 'ambiguous', '0')
    assert 0.0 < visibility(case, signals_of(case))[0]['likeness'] <= 1.0


@pytest.mark.long
def test_a_seed_gives_the_same_bags_and_labels_again(suite, tmp_path):
    directory, labels = suite
    again = tmp_path / 'again'
    generate('development', CASES, 4, again, tmp_path / 'labels.json', jobs=1)
    assert (tmp_path / 'labels.json').read_bytes() == labels.read_bytes()
    for bag in sorted(directory.glob('*/*/*.mcap')):
        assert (again / bag.relative_to(directory)).read_bytes() == bag.read_bytes(), bag
    assert sorted(p.relative_to(directory) for p in directory.rglob('*')) == sorted(
        p.relative_to(again) for p in again.rglob('*')
    )


def test_bags_have_the_topics_of_the_contract(suite):
    directory, _ = suite
    kinds = {'/temperature': 'sensor_msgs/msg/Temperature'}
    for bag in sorted(directory.glob('*/recording_*')):
        with AnyReader([bag]) as reader:
            topics = {c.topic: c.msgtype for c in reader.connections}
            assert set(topics) <= TOPICS
            assert len(set(topics) & {'/current', '/power', '/voltage'}) == 1
            last = 0
            for connection, logged, raw in reader.messages():
                message = reader.deserialize(raw, connection.msgtype)
                assert topics[connection.topic] == kinds.get(connection.topic, 'std_msgs/msg/Float64')
                assert logged >= last
                last = logged
                if connection.topic == '/temperature':
                    stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
                    assert 0 < logged - stamp < 1_000_000  # ns
                    assert 15.0 < message.temperature < 130.0
                    assert message.variance > 0.0
                else:
                    assert np.isfinite(message.data)


def test_resistance_is_only_there_while_current_flows(suite):
    directory, _ = suite
    seen = False
    for bag in sorted(directory.glob('*/recording_*')):
        with AnyReader([bag]) as reader:
            if {'/current', '/resistance'} <= set(reader.topics):
                times: dict[str, list[tuple[int, float]]] = {'/current': [], '/resistance': []}
                chosen = [c for c in reader.connections if c.topic in times]
                for connection, logged, raw in reader.messages(chosen):
                    times[connection.topic].append((logged, reader.deserialize(raw, connection.msgtype).data))
                logged, current = np.array(times['/current']).T
                at = np.searchsorted(logged, [t - 1_000_000 for t, _ in times['/resistance']])
                # a supply that lags has current for a moment after it was told to stop
                assert np.mean(current[np.clip(at, 0, len(current) - 1)] > 0.003) > 0.97
                assert len(times['/resistance']) < len(current)
                seen = True
    assert seen


def test_labels_are_sealed_and_not_among_the_cases(suite, tmp_path):
    directory, labels = suite
    seal = (directory / 'SEAL').read_text().split()[0]
    assert hashlib.sha256(labels.read_bytes()).hexdigest() == seal
    assert not [p for p in directory.rglob('*') if p.suffix not in ('.mcap', '.yaml', '') or 'label' in p.name]
    names = set(EFFECTS)
    for path in directory.rglob('*'):
        if path.is_file() and path.name != 'SEAL':
            content = path.read_bytes()
            assert not [name for name in names if name.encode() in content], path
    forged = tmp_path / 'labels.json'
    forged.write_text(labels.read_text().replace('single', 'null'))
    with pytest.raises(SystemExit, match='SHA-256'):
        read(directory, tmp_path, forged)


def test_an_invisible_effect_is_labelled_undetectable_and_an_obvious_one_is_not():
    case = make_case('development', 3, 0, 'single', 'contact_resistance')
    assert not visibility(case, signals_of(case))[0]['detectable']
    for seed in range(8):
        case = make_case('development', seed, 0, 'single', 'natural_convection')
        assert visibility(case, signals_of(case))[0]['detectable']


def test_a_plain_muscle_leaves_nothing_after_the_refit():
    case = make_case('development', 2, 1, 'null', '')
    refit = Refit(case)
    left = refit.measure(refit.left(stack(signals_of(case))))
    assert max(left['peak'].values()) < 0.1
    assert not left['detectable']


def test_every_other_null_is_a_muscle_that_its_lab_knows():
    moved, known = (make_case('development', 2, number, 'null', '') for number in (2, 3))
    assert (moved.nominal, moved.verdicts) == ({}, ('wrong_parameters',))
    assert known.verdicts == ('match',)
    assert known.nominal == pytest.approx({name: getattr(known.lab.body, name) for name in BASE})


def test_noise_has_the_spectrum_it_claims():
    noise = Noise(sigma=0.3, coloured=0.6, pole=0.9, quantum=0.0, lost=0.0, bursts=0)
    rng = np.random.default_rng(1)
    n = 256
    power = np.mean([np.abs(np.fft.rfft(noise.draw(rng, n))) ** 2 / n for _ in range(2000)], axis=0)
    assert power[2:-1] / noise.density(n)[2:-1] == pytest.approx(1.0, abs=0.15)


def test_an_experiment_can_be_added_to_a_sealed_case(suite, tmp_path):
    directory, labels = suite
    name = json.loads(labels.read_text())['cases'][0]['case']
    before = len(list((directory / name).glob('recording_*')))
    protocol = tmp_path / 'next.yaml'
    protocol.write_text(
        'rate_hz: 20\nsegments: [{duration_s: 10, value: 0.1, load_n: 0.4}, {duration_s: 5, value: [0.1, 0]}]'
    )
    bag = extend(directory, name, protocol, labels)
    assert bag.name == f'recording_{before}'
    with AnyReader([bag]) as reader:
        assert reader.duration == pytest.approx(15e9, rel=0.02)


def test_an_added_experiment_is_done_to_a_muscle_that_has_worn(tmp_path):
    cases, labels, protocol = tmp_path / 'cases', tmp_path / 'labels.json', tmp_path / 'next.yaml'
    generate('development', 1, 4, cases, labels, jobs=1, wanted=[('single', 'fatigue')])
    protocol.write_text('rate_hz: 20\nsegments: [{duration_s: 15, value: 0.2}]')
    bag = extend(cases, 'case_0000', protocol, labels)
    case = make_case('development', 4, 0, 'single', 'fatigue')
    worn, further = signals_of(case)[-1].dose, as_experiment(yaml.safe_load(protocol.read_text()), case)
    k = len(case.experiments)
    again = write_recording(case, k, further, observe(case.bench, further, k, worn), tmp_path / 'again')
    assert worn > 1.0
    np.testing.assert_array_equal(*(read_bag(path)['displacement'].value for path in (bag, again)))
