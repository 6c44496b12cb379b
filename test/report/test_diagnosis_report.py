"""What a diagnosis leaves behind: every file, for every verdict, says what the diagnosis says."""

import json
import resource
from dataclasses import replace
from html import unescape

import jsonschema
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from report.diagnoses import (
    ALL,
    NOMINAL,
    convection_or_radiation,
    creep,
    experiment,
    match,
    not_repeatable,
    sensor_or_setup,
    series_of,
    wrong_parameters,
)
from report.html_page import Page

from tcp_muscle_ros.diagnosis.answer.findings import VERDICTS, Imitated, Sticking, Value
from tcp_muscle_ros.diagnosis.answer.issues import with_faults
from tcp_muscle_ros.diagnosis.answer.replaying import replay
from tcp_muscle_ros.diagnosis.fitting.calibration import Estimate, Known
from tcp_muscle_ros.diagnosis.model.unknown import Unknown
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import writable_folder
from tcp_muscle_ros.muscle import EFFECTS, ZERO_CELSIUS
from tcp_muscle_ros.recording.bag import read_bag
from tcp_muscle_ros.recording.protocol import parse_protocol, read_protocol
from tcp_muscle_ros.recording.yaml_input import Section
from tcp_muscle_ros.report import words
from tcp_muscle_ros.report.diagnosis_figures import draw_all, draw_loop
from tcp_muscle_ros.report.page import render
from tcp_muscle_ros.report.protocol_file import render_protocol, write_improved, write_protocol
from tcp_muscle_ros.report.report_json import as_data, schema
from tcp_muscle_ros.report.style import PREDICTED
from tcp_muscle_ros.report.telling import compared, telling_channel, telling_recording, thin
from tcp_muscle_ros.report.terminal import WIDTH, summary
from tcp_muscle_ros.report.viewer import embedded, viewer_data
from tcp_muscle_ros.report.write import refuse_report, write_report
from tcp_muscle_ros.settings.intervals import variants
from tcp_muscle_ros.settings.parameter_file import read

# The names of the report's contract, as programs rely on them: key -> keys below it.
CONTRACT = {
    'schema': None,
    'partial': None,
    'recordings': {'path', 'duration_s', 'rate_hz', 'channels', 'issues'},
    'noise': None,
    'repeatability': None,
    'verdict': None,
    'verdict_probability': None,
    'calibration': {'nominal', 'value', 'low', 'high', 'unit'},
    'location': {'stage', 'channel', 'phase', 'drivers', 'intervals_s'},
    'findings': {
        'effect',
        'stage',
        'sentence',
        'equation',
        'parameters',
        'probability',
        'singled_out',
        'indistinguishable_from',
        'improvement',
        'unlisted',
    },
    'fit': {'rmse_nominal', 'rmse_calibrated', 'rmse_improved', 'rmse_fitted', 'noise', 'held_out'},
    'not_testable': {'effect', 'why'},
    'unexplained': {'stage', 'channel', 'share', 'driver', 'interval_s'},
    'next_experiment': {'separates', 'protocol', 'power'},
    'would_help': None,
    'improved_parameters': None,
}


@pytest.fixture(scope='module')
def reports(made, tmp_path_factory):
    """A report of each."""
    folder = tmp_path_factory.mktemp('reports')
    for name, (diagnosis, experiments) in made.items():
        write_report(folder / name, diagnosis, experiments)
    return folder


def test_the_helper_has_every_verdict(made):
    assert {diagnosis.verdict for diagnosis, _ in made.values()} == set(VERDICTS)


@pytest.mark.parametrize('name', ALL)
def test_json_keeps_its_schema(reports, name):
    def refuse(constant):
        raise AssertionError(f'{constant} is no JSON')

    content = json.loads((reports / name / 'report.json').read_text(), parse_constant=refuse)
    jsonschema.Draft202012Validator(schema()).validate(content)
    for key, below in CONTRACT.items():
        assert key in content
        found = content[key]
        members = {'calibration': dict.values, 'fit': dict.values}.get(key, lambda f: f if isinstance(f, list) else [f])
        for member in members(found) if below and found else ():
            assert below <= set(member)


def test_the_schema_is_one_and_knows_every_key_of_the_contract():
    jsonschema.Draft202012Validator.check_schema(schema())
    assert set(schema()['required']) == set(CONTRACT)
    assert tuple(schema()['properties']['verdict']['enum']) == VERDICTS


@pytest.mark.parametrize(
    ('key', 'wrong'),
    [
        ('verdict', 'guilty'),
        ('findings', [{'effect': 'creep'}]),
        ('noise', {'smell': 1.0}),
        ('fit', {'displacement': {'rmse_nominal': -1.0}}),
        ('next_experiment', {'separates': ['creep'], 'protocol': 'next_protocol.yaml', 'power': 0.5}),
        ('next_experiment', {'separates': ['creep', 'slack'], 'protocol': 'next_protocol.yaml', 'power': 0.4}),
        ('location', {'stage': 'thermal', 'channel': 'force', 'phase': [], 'drivers': [], 'intervals_s': [[0, 1, 2]]}),
        ('location', {}),
    ],
)
def test_the_schema_refuses(made, key, wrong):
    content = {**as_data(made['convection_or_radiation'][0]), key: wrong}
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(content, schema())
    del content[key]
    with pytest.raises(jsonschema.ValidationError, match=key):
        jsonschema.validate(content, schema())


def test_json_says_what_the_diagnosis_says(made):
    d, _ = made['creep']
    content = as_data(d)
    assert content['headline'] == d.headline
    (finding,) = content['findings']
    assert finding['parameters']['J'] == {
        'nominal': 0.0,
        'value': 0.347,
        'low': 0.339,
        'high': 0.356,
        'unit': '1',
        'fixed_by_data': True,
        'at_bound': False,
    }
    assert finding['improvement'] == {'displacement': {'rmse_without': 1.9e-3, 'rmse_with': 4.3e-5}}
    assert content['location']['intervals_s'] == [[1, 30.0, 52.0], [1, 90.0, 112.0], [2, 30.0, 55.0]]
    assert content['location']['drivers'][0] == {
        'variable': 'temperature',
        'low': 45.0,
        'high': 80.0,
        'unit': 'degC',
        'share': 0.71,
    }
    assert content['calibration']['hA']['value'] == pytest.approx(d.calibration['hA'].value, rel=1e-8)
    assert content['fit']['displacement']['rmse_calibrated'] == pytest.approx(d.fit['displacement'].calibrated)


def test_absolute_temperatures_are_in_degc_and_differences_stay(made):
    content = as_data(made['match'][0])
    ambient = content['calibration']['ambient [1]']
    assert (ambient['value'], ambient['unit']) == (23.25, 'degC')
    offset = content['calibration']['temperature_offset']
    assert (offset['value'], offset['unit']) == (0.1, 'K')
    assert content['sensors'] == ['temperature_offset']
    assert words.at_edge('T0', Value(296.15, 295.15, 297.15, 'K', 296.15)).value == 23.0
    assert not words.is_absolute('ambient_drift.rate')


def test_numbers_that_do_not_exist_are_null(made):
    d, _ = made['unexplained']
    assert as_data(d)['location']['size'] is None
    assert as_data(made['insufficient_data'][0])['noise'] == {'temperature': None}


@pytest.mark.parametrize('name', ALL)
def test_the_page_is_self_contained_and_opens_with_verdict_and_headline(made, reports, name):
    text = (reports / name / 'report.html').read_text()
    page, d = Page(text), made[name][0]
    assert page.said[0] == words.plain(d.verdict)
    assert d.headline in page.said[:4]
    assert 'http' not in text.replace('http://www.w3.org/2000/svg', '')
    assert not {'link', 'iframe'} & {tag for tag, _ in page.tags}
    assert not any('src' in attributes for tag, attributes in page.tags if tag == 'script')
    images = [attributes for tag, attributes in page.tags if tag == 'img']
    assert len(images) == len(list((reports / name / 'figures').glob('*.png')))
    assert all(image['src'].startswith('data:image/png;base64,') for image in images)
    assert 'url(' not in text.replace('url(#${clip})', '')
    assert ('interrupted' in text) == d.partial


@pytest.mark.parametrize('name', ALL)
def test_every_image_has_a_text_of_its_own_for_who_cannot_see_it(reports, name):
    tags = Page((reports / name / 'report.html').read_text()).tags
    told = [attributes['alt'] for tag, attributes in tags if tag == 'img']
    told += [attributes['aria-label'] for tag, attributes in tags if tag == 'svg']
    assert all(len(text) > 15 for text in told)
    assert len(set(told)) == len(told)


def test_the_page_tells_everything(made):
    d, _ = made['three_effects']
    text = unescape(render(d))
    for finding in d.findings:
        assert finding.sentence in text
        assert finding.equation in text
        assert words.plain(finding.effect) in text
    for part in ('ould as well be radiation', '0.347 (0.339 to 0.356)', '42 % of the misfit of the displacement'):
        assert part in text
    assert 'no slow part' in text
    for part in ('temperature 45 to 80 degC', 'next_protocol.yaml', 'probability 93 %', 'lab/run_2', d.notes[0]):
        assert part in text


def test_what_others_wrote_is_text_on_the_page(made):
    d, _ = made['creep']
    evil = '<img src="https://example.org/x" onerror="x()"> & "quoted"'
    recordings = tuple(replace(r, path=evil, issues=(evil,)) for r in d.recordings)
    found = replace(d.findings[0], sentence=evil, equation=evil, effect=evil)
    page = Page(render(replace(d, headline=evil, recordings=recordings, findings=(found,), notes=(evil,))))
    assert all(tag != 'img' for tag, _ in page.tags)
    assert '<' not in embedded({'name': evil})
    assert evil in page.said


@pytest.mark.parametrize('name', ALL)
def test_the_terminal_says_all_of_it_in_lines_that_are_not_too_long(made, name):
    d, _ = made[name]
    text = summary(d, 'report.html')
    lines = text.splitlines()
    assert max(len(line) for line in lines) <= WIDTH
    said = ' '.join(text.split())
    assert '...' not in said and said.startswith(d.headline)
    for told in (*d.notes, *d.would_help[:1]):
        assert told in said
    assert d.verdict in text
    assert ('partial' in text) == d.partial
    assert lines[-1] == 'report: report.html'
    for finding in d.findings:
        assert words.plain(finding.effect) in text


def test_the_terminal_says_where_what_and_how_well(made):
    text = summary(made['creep'][0])
    assert 'J 0.347 (0.339 to 0.356), tau50 25.1 (24.0 to 26.3) s' in text
    assert 'mechanical stage, displacement, cooling and transition; largest at temperature 45 to 80 degC' in text
    assert '0.0411 mm' in text
    assert 'could as well be radiation' in summary(made['convection_or_radiation'][0])


def test_the_terminal_gives_the_numbers_of_every_finding_whole(made):
    starts = {f'creep.start [{k}]': Value(0.1 * k, 0.1 * k - 0.01, 0.1 * k + 0.01, '1', 0.0) for k in range(1, 6)}
    d, _ = made['three_effects']
    (first, second, third) = d.findings
    longer = replace(first, parameters={**first.parameters, **starts})
    third = replace(third, parameters={'geometric_stiffening.g': Value(0.3, 0.2, 0.4, '1')})
    headline = f'{d.headline} The error on unseen data falls from 0.38 mm to 0.041 mm (noise 0.048 mm).'
    said = ' '.join(summary(replace(d, headline=headline, findings=(longer, second, third))).split())
    assert headline in said
    assert 'n 0.190 (0.170 to 0.210)' in said and 'g 0.30 (0.20 to 0.40)' in said
    assert all(
        f'start [{k}] {words.parameter_text("creep", "start", starts[f"creep.start [{k}]"])}' in said
        for k in range(1, 6)
    )
    assert 'fatigue, first cycle, inertia and 6 more, in the report' in said


def test_the_terminal_tells_a_law_without_a_name_by_its_driver(made):
    text = summary(replace(made['unlisted'][0], unexplained=made['unexplained'][0].unexplained))
    assert 'probability 0.61; no listed effect explains it' in text
    said = ' '.join(text.split())
    assert '0.019 to 0.024 W/K over the temperature, a curve in the report; nearest is natural convection (41 %' in said
    assert 'explained by no listed effect, but by that law: 42 % of the misfit' in text
    assert 'value_1' not in text
    assert 'unexplained' not in text


def test_a_law_in_words_is_in_the_data_and_beside_its_curve(made):
    with_words = made['unlisted'][0]
    (finding,) = as_data(with_words)['findings']
    assert finding['unlisted']['nearest_share'] == 0.41
    said = finding['unlisted']['in_words']
    assert said['form'] == 'linear' and said['parameters']['o'] == {'value': 23.0, 'unit': 'degC'}
    assert len(said['curve']) == len(finding['unlisted']['curve']['at'])
    assert 'dashed: the form in words' in render(with_words)
    (found,) = with_words.findings
    plain = replace(with_words, findings=(replace(found, unlisted=replace(found.unlisted, in_words=None)),))
    content = as_data(plain)
    assert content['findings'][0]['unlisted']['in_words'] is None
    jsonschema.validate(content, schema())
    assert 'dashed' not in render(plain)


def test_the_page_calls_what_a_law_without_a_name_explains_as_the_terminal_does(made):
    left = made['unexplained'][0].unexplained
    assert '<h2>Unexplained</h2>' in render(replace(made['creep'][0], unexplained=left))
    page = render(replace(made['unlisted'][0], unexplained=left))
    assert '<h2>Explained by no listed effect, but by that law</h2>' in page and '<h2>Unexplained' not in page


def test_what_was_not_tried_is_not_said_to_explain_nothing(made):
    d = made['unexplained'][0]
    for tried, said in ((d, 'no listed effect explains'), (replace(d, ranking=()), 'no listed effect was tried')):
        page, text = render(tried).lower(), ' '.join(summary(tried).split())
        assert said in page and said in text
        assert 'no listed effect was tried' not in page + text or not tried.ranking
    assert 'listed effect explains' not in page + text and 'not a listed effect' not in page


def test_rig_yaml_says_which_limits_were_recorded_and_which_are_usual(reports):
    heading = ' '.join((reports / 'match' / 'rig.yaml').read_text().replace('# ', '').split())
    assert 'loads_n and held_end are what was recorded, and so is largest_current_a where a current was' in heading
    assert 'not measured: check highest_temperature_c, loads_by and longest_run_s (an hour, or' in heading
    assert 'duration recorded' not in heading


@pytest.mark.parametrize('name', ['creep', 'convection_or_radiation', 'three_effects', 'sensor_or_setup', 'match'])
def test_improved_loads_and_is_the_improved_muscle(made, reports, name):
    d, _ = made[name]
    loaded = read(reports / name / 'improved.yaml').parameters
    assert loaded.effects == tuple(e for e in d.improved.effects if EFFECTS[e].stage != 'sensor')
    names = [n for n in loaded if '.' not in n or n.split('.')[0] in loaded.effects]
    assert {n: loaded[n] for n in names} == pytest.approx({n: d.improved[n] for n in names}, rel=1e-12)


def test_improved_replays_to_the_error_of_the_report(tmp_path):
    d, (first, _) = creep()
    write_improved(tmp_path / 'improved.yaml', d)
    compared_now = replay(first, read(tmp_path / 'improved.yaml').parameters)['displacement']
    error = compared_now.recorded - compared_now.predicted
    assert np.std(error) == pytest.approx(np.std(d.series[0][2].recorded - d.series[0][2].after), rel=0.05)


def test_improved_says_what_it_is_and_how_sure(made, tmp_path):
    d, _ = made['creep']
    write_improved(tmp_path / 'improved.yaml', d, {'load_n': 0.59})
    text = (tmp_path / 'improved.yaml').read_text()
    assert text.startswith('# A muscle improved by tcp_muscle diagnose from 2 recordings.')
    lines = {line.split(':')[0].strip(): line for line in text.splitlines() if '#' in line[4:]}
    assert lines['creep.J'].endswith('90 %: 0.339 to 0.356')
    assert lines['k0'].endswith('not fixed by the data')
    assert 'Table 1' in lines['L0']
    assert read(tmp_path / 'improved.yaml').operating == {'load_n': 0.59}


def test_a_value_that_each_recording_has_for_itself_is_handed_on_as_their_mean(made, tmp_path):
    d, _ = made['creep']
    own = {f'B [{k}]': replace(d.calibration['hA'], value=0.6 + 0.01 * k) for k in (1, 2)}
    shared = {name: value for name, value in d.calibration.items() if name != 'B'}
    write_improved(tmp_path / 'improved.yaml', replace(d, calibration={**shared, **own}))
    (line,) = (line for line in (tmp_path / 'improved.yaml').read_text().splitlines() if ' B: ' in line)
    assert line.endswith('; mean of the recordings') and 'derived' not in line


@pytest.mark.parametrize('verdict', ['missing_physics', 'sensor_or_setup'])
@pytest.mark.parametrize(('probability', 'sure'), [(0.36, False), (0.7, True), (None, True)])
def test_a_verdict_that_is_more_likely_wrong_says_may(made, verdict, probability, sure):
    d = replace(made['match'][0], verdict=verdict, verdict_probability=probability)
    assert (' may ' in words.verdict_words(d)) is not sure
    assert words.verdict_words(d) in ' '.join(summary(d).split())


def test_an_interval_that_belongs_to_another_value_is_not_written(made, tmp_path):
    d, _ = made['creep']
    far = replace(d, improved=d.improved.replace(hA=2.0 * NOMINAL['hA']))
    write_improved(tmp_path / 'improved.yaml', far)
    (line,) = (line for line in (tmp_path / 'improved.yaml').read_text().splitlines() if ' hA: ' in line)
    assert line.endswith('fitted')


def test_the_next_protocol_reads_back(made, reports):
    proposal = made['convection_or_radiation'][0].next_experiment
    protocol = read_protocol(reports / 'convection_or_radiation' / 'next_protocol.yaml')
    assert (protocol.rate_hz, protocol.kind, protocol.end, protocol.repeat) == (20.0, 'current', 'load', 2)
    assert protocol.load == 0.59
    read_back = [(s.duration, s.value.start, s.value.end, s.load.start) for s in protocol.segments]
    assert read_back == [(step.duration, step.current, step.current, step.load) for step in proposal.steps]
    assert not (reports / 'creep' / 'next_protocol.yaml').exists()


@given(st.floats(0.01, 0.5), st.floats(5.0, 40.0))
def test_the_next_protocol_asks_for_no_more_than_was_planned_in_the_room_it_was_planned_for(current, room):
    planned = convection_or_radiation()[0].next_experiment
    steps = tuple(replace(step, current=current) for step in planned.steps)
    proposal = replace(planned, steps=steps, ambient=ZERO_CELSIUS + room)
    protocol = parse_protocol(Section(yaml.safe_load(render_protocol(proposal)), 'next_protocol.yaml'))
    assert current * (1.0 - 1e-5) <= protocol.sampled().drive.max() <= current
    assert proposal.ambient - 2e-3 <= protocol.ambient <= proposal.ambient
    assert set(protocol.sampled().ambient) == {protocol.ambient}


def test_a_proposal_for_a_spring_keeps_the_spring(tmp_path):
    d, (made,) = convection_or_radiation()
    holding = replace(made.holding, end='spring', spring_rate=30.0, spring_rest_length=0.01)
    odd = replace(d.next_experiment, end='spring', reason='two\nlines: # and more', power=float('nan'), rate=12.5)
    write_protocol(tmp_path / 'next.yaml', odd, holding)
    protocol = read_protocol(tmp_path / 'next.yaml')
    assert protocol.end_options == {'spring_rate_n_per_m': 30.0, 'spring_rest_length_m': 0.01}


def test_the_overlay_holds_recorded_before_and_after_of_each_recording(made, reports):
    d, experiments = made['creep']
    for k, series in enumerate(d.series):
        for part in ('recorded', 'before', 'after'):
            bag = read_bag(reports / 'creep' / 'overlay', namespace=f'/recording_{k + 1}/{part}')
            for s in series:
                np.testing.assert_allclose(bag[s.channel].value, getattr(s, part), rtol=1e-12)
                np.testing.assert_allclose(bag[s.channel].time, s.time, atol=1e-6)
    assert 'current' in read_bag(reports / 'match' / 'overlay', namespace='/recorded')
    assert len(experiments) == 2


def test_figures_show_what_there_is(made, reports):
    drawn = {name: {path.stem for path in (reports / name / 'figures').iterdir()} for name in made}
    assert drawn['convection_or_radiation'] == {'channels', 'driver', 'loop', 'ranking', 'experiment'}
    assert drawn['match'] == {'channels', 'driver', 'loop'}
    assert drawn['insufficient_data'] == set()
    assert all(path.stat().st_size > 5000 for path in reports.glob('*/figures/*.png'))


def test_one_cycle_is_drawn_where_the_drive_is_never_off(made, tmp_path):
    """As under the small current that keeps the resistance readable: a cycle begins where the muscle begins to warm."""
    d, _ = made['creep']
    always = [tuple(replace(s, heating=np.ones(s.heating.size)) for s in series) for series in d.series]
    for name, series in (('sometimes', d.series), ('always', tuple(always))):
        caption = draw_loop(tmp_path / f'{name}.png', replace(d, series=series)).caption
        start, end = (float(part.split(' s')[0]) for part in caption.split('(')[1].split(' to '))
        assert 0.0 < end - start < 0.5 * np.ptp(d.series[1][0].time), caption


def test_figures_speak_of_the_recording_and_channel_that_show_most(made):
    d, _ = made['creep']
    assert telling_channel(d) == 'displacement'
    assert telling_recording(d) == 1
    assert [model.part for model in compared(d)] == ['before', 'after']
    assert [model.part for model in compared(made['wrong_parameters'][0])] == ['nominal', 'before']
    assert telling_channel(made['wrong_parameters'][0]) == 'displacement'


@pytest.mark.parametrize('verdict', ['unexplained', 'not_repeatable', 'sensor_or_setup'])
def test_what_is_missed_and_has_no_name_is_drawn_beside_no_model_that_hides_it(made, tmp_path, verdict):
    d = replace(made['unexplained'][0], verdict=verdict)
    (model,) = compared(d)
    assert (model.part, model.look['color']) == ('before', PREDICTED)
    assert [len(c['models']) for r in viewer_data(d)['recordings'] for c in r['channels']] == [1] * len(d.series[0])
    for figure in draw_all(tmp_path, d):
        assert 'nominal' not in figure.said.caption + figure.said.alternative, figure.file
    page = render(d)
    assert '</i>recalibrated</span>' in page and '</i>nominal</span>' not in page


def test_long_recordings_are_thinned_and_odd_ones_are_drawn(tmp_path):
    assert thin(10).tolist() == list(range(10))
    assert thin(1_000_000).size == 3000
    assert thin(1_000_000)[[0, -1]].tolist() == [0, 999_999]
    d, _ = match()
    few = tuple(
        replace(s, **{f: getattr(s, f)[:2] for f in s.__dataclass_fields__ if f != 'channel'}) for s in d.series[0]
    )
    assert draw_all(tmp_path, replace(d, series=(few,), noise={}))
    long, _ = ALL['creep']()
    made = experiment(NOMINAL, duration=1500.0, rate=2.0)
    d = replace(long, series=(series_of(made, NOMINAL, NOMINAL, NOMINAL),))
    assert draw_all(tmp_path, d)


def test_a_report_is_never_overwritten(made, tmp_path):
    d, experiments = made['insufficient_data']
    (tmp_path / 'empty').mkdir()
    write_report(tmp_path / 'empty', d, experiments)
    with pytest.raises(BadInput, match='not empty'):
        write_report(tmp_path / 'empty', d, experiments)
    (tmp_path / 'file').write_text('kept')
    with pytest.raises(BadInput, match='is a file'):
        refuse_report(tmp_path / 'file')
    with pytest.raises(BadInput, match='does not exist'):
        refuse_report(tmp_path / 'no' / 'such')


def test_a_report_that_finds_the_disk_full_leaves_nothing_and_does_not_block_the_next(made, tmp_path):
    d, experiments = made['match']
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
    try:
        with pytest.raises(BadInput, match=r'report: cannot be written \(File too large\)'):
            write_report(tmp_path / 'report', d, experiments)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert list(tmp_path.iterdir()) == []
    d, experiments = made['insufficient_data']
    write_report(tmp_path / 'report', d, experiments)
    old = tmp_path / 'report' / 'figures' / 'old'
    old.write_text('')
    write_report(tmp_path / 'report', d, experiments, force=True)
    assert not old.exists()
    assert [path.name for path in tmp_path.iterdir()] == ['report']


def test_a_report_holds_nothing_that_force_would_not_replace(reports):
    for folder in reports.iterdir():
        assert writable_folder(folder, force=True) == folder


def test_a_name_between_dollars_is_no_formula(made, tmp_path):
    d, _ = made['match']
    named = replace(d, recordings=tuple(replace(r, path='lab/price $a^$ 2') for r in d.recordings))
    assert draw_all(tmp_path, named)


def test_intervals_stand_beside_the_improved_muscle_and_go_with_an_older_report(made, tmp_path):
    d, experiments = made['match']
    k0 = Unknown('k0', d.improved['k0'], 1.0, 100.0, 1.0, log=True)
    row = Estimate('k0', None, NOMINAL['k0'], d.improved['k0'], 20.0, 25.0, 'N/m', True, False, None)
    write_report(tmp_path / 'report', replace(d, known=Known((row,), (k0,), np.array([[0.01]]))), experiments)
    improved = tmp_path / 'report' / 'improved.yaml'
    drawn = variants(improved, read(improved).parameters)
    assert np.std(np.log([one['k0'] for one in drawn.values()])) == pytest.approx(0.1, rel=0.3)
    write_report(tmp_path / 'report', d, experiments, force=True)
    assert variants(improved, read(improved).parameters) is None
    assert not (tmp_path / 'report' / 'improved.intervals.json').exists()


def test_sensor_effects_stay_out_of_the_muscle(tmp_path):
    d, _ = sensor_or_setup()
    assert 'thermocouple_lag' in d.improved.effects
    write_improved(tmp_path / 'improved.yaml', d)
    body = (tmp_path / 'improved.yaml').read_text().split('ros__parameters')[1]
    assert 'thermocouple_lag' not in body


@pytest.mark.parametrize(
    ('value', 'text'),
    [
        (Value(0.1, 0.092, 0.108, 'N/m'), '0.100 (0.092 to 0.108) N/m'),
        (Value(25.13, 24.02, 26.31, 's'), '25.1 (24.0 to 26.3) s'),
        (Value(-3.5e-6, -3.6e-6, -3.4e-6, '1/K^2'), '-3.5e-06 (-3.6e-06 to -3.4e-06) 1/K^2'),
        (Value(1.0, float('nan'), float('nan'), '1'), '1.00'),
        (Value(0.0, -0.1, 0.1, 'K'), '0.00 (-0.10 to 0.10) K'),
    ],
)
def test_a_value_is_read_with_its_interval(value, text):
    assert words.value_text(value) == text


def test_a_choice_is_read_by_its_name():
    assert words.parameter_text('two_node', 'pull', Value(1.0, 1.0, 1.0, '1', 0.0)) == 'core and sheath'
    assert words.parameter_text('two_node', 'f', Value(0.5, 0.4, 0.6, '1', 0.5)) == '0.50 (0.40 to 0.60)'


def test_a_sensor_that_stands_still_is_the_verdict_before_whatever_is_weaker():
    for made in (match, wrong_parameters, not_repeatable):
        assert with_faults(made()[0], ['displacement stands still']).verdict == 'sensor_or_setup'
    assert with_faults(creep()[0], ['displacement stands still']).verdict == 'missing_physics'


def test_a_run_that_sticks_is_shown_beside_a_simulated_one(tmp_path):
    d, _ = match()
    time = np.arange(100) / 5.0
    run = Imitated('run_1', 'displacement', time, np.floor(time) * 1e-3, np.floor(time + 0.5) * 1e-3)
    drawn = draw_all(tmp_path, replace(d, imitated=run))
    assert (tmp_path / 'sticking.png').exists() and 'sticking.png' not in {f.file for f in draw_all(tmp_path, d)}
    page = render(replace(d, imitated=run), drawn, tmp_path)
    assert 'One recorded run and one simulated: the same kind of motion' in page


@pytest.mark.parametrize('values', [{}, {'stick_slip.Fb': 0.01, 'stick_slip.s': 0.86}])
def test_that_a_run_sticks_is_data(values):
    d, _ = match()
    assert as_data(d)['sticking'] is None
    alike = (0.5, 0.1) if values else (None, None)
    content = as_data(
        replace(d, sticking=Sticking('displacement', ('run_1',), 3, (0.4, 7.2), (3e-4, 2e-3), values, *alike))
    )
    jsonschema.validate(content, schema())
    found = content['sticking']
    assert {name: p['value'] for name, p in found['parameters'].items()} == values
    assert (found['recordings'], found['rests_s'], found['alike_rests']) == (['run_1'], [0.4, 7.2], alike[1])
