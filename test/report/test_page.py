"""The page of a diagnosis: what its first screen, its commands and its words say."""

import argparse
import shlex
from base64 import b64decode
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from report.diagnoses import ALL
from report.html_page import Page

from tcp_muscle_ros.diagnosis.answer.findings import Member
from tcp_muscle_ros.muscle import EFFECTS
from tcp_muscle_ros.report import words
from tcp_muscle_ros.report.diagnosis_figures import draw_channels
from tcp_muscle_ros.report.next_steps import Asked, steps
from tcp_muscle_ros.report.page import render
from tcp_muscle_ros.report.ranking import ranking_words
from tcp_muscle_ros.report.report_json import as_data
from tcp_muscle_ros.report.rig_checks import check_on_rig, has_check
from tcp_muscle_ros.report.telling import telling_recording
from tcp_muscle_ros.report.terminal import summary
from tcp_muscle_ros.report.viewer import viewer_data
from tcp_muscle_ros.settings.rig import Rig, RigLimits


def arguments(command):
    """What the tool makes of a command that can be pasted."""
    _, name, *rest = shlex.split(command)
    parser = argparse.ArgumentParser()
    import_module(f'tcp_muscle_ros.commands.{name}').add_arguments(parser)
    return parser.parse_args(rest)


def test_sixteen_long_recordings_fit_in_a_page_of_five_megabytes(made):
    d, _ = made['creep']
    (first, _), (drive, _) = d.series, d.drive
    time = np.linspace(0.0, 1800.0, 20_000)
    long = tuple(
        replace(
            s, time=time, **{
                part: np.interp(time, 6.0 * s.time, getattr(s, part).astype(float))
                for part in ('recorded', 'nominal', 'before', 'after', 'temperature', 'rate', 'heating')
            }
        )
        for s in first
    )  # fmt: skip
    recordings = tuple(replace(d.recordings[0], path=f'lab/run_{k}') for k in range(16))
    many = replace(d, series=(long,) * 16, drive=(drive,) * 16, recordings=recordings)
    text = render(many)
    assert len(text.encode()) < 5e6
    data = viewer_data(many)
    assert [r['name'] for r in data['recordings']] == [f'run_{k}' for k in range(16)]
    shown = np.frombuffer(b64decode(data['recordings'][15]['channels'][0]['time']), '<f4')
    assert shown.size > 1000 and shown[[0, -1]].tolist() == [0.0, 1800.0]


def test_what_is_shaded_is_said_only_where_it_is_drawn(made, tmp_path):
    d, _ = made['creep']
    assert 'Shaded' in draw_channels(tmp_path / 'a.png', d).caption
    elsewhere = replace(d, location=replace(d.location, intervals=((0, 30.0, 52.0),)))
    assert telling_recording(elsewhere) == 1
    assert 'Shaded' not in draw_channels(tmp_path / 'b.png', elsewhere).caption
    data = viewer_data(elsewhere)
    assert [r['shaded'] for r in data['recordings']] == [[(30.0, 52.0)], []]


def test_the_ranking_is_in_words(made):
    d, _ = made['creep']
    assert ranking_words(d) == [
        ('Found', 'creep'),
        ('Explains as much', 'nothing else'),
        ('Explains a part of it alone', 'viscous flow (45 %), hysteresis (37 %), branch cte (24 %)'),
        ('Explains little', 'cte kink (5 %), thermocouple lag (2 %), natural convection (0 %), radiation (0 %)'),
    ]
    assert ('Explains as much', 'radiation') in ranking_words(made['convection_or_radiation'][0])
    assert ranking_words(made['match'][0]) == []
    assert 'log likelihood' not in render(d)


def test_the_commands_of_a_report_are_those_of_the_tool_with_the_paths_that_were_given(made, tmp_path):
    d, _ = made['convection_or_radiation']
    (tmp_path / 'my muscle.yaml').write_text('')
    asked = Asked(
        ('lab/run 1',), str(tmp_path / 'my muscle.yaml'), str(tmp_path / 'out'), ('--unit', 'displacement=mm')
    )
    commands = [command for step in steps(d, asked) for command in step.commands]
    assert [shlex.split(command)[:2] for command in commands] == [
        ['tcp_muscle', 'replay'], ['tcp_muscle', 'run'], ['tcp_muscle', 'diagnose'], ['sim_node', '--ros-args']
    ]  # fmt: skip
    parsed = [arguments(command) for command in commands[:3]]
    seen, played, again = parsed
    assert played.protocol == str(tmp_path / 'out' / 'next_protocol.yaml')
    assert again.bags == [str(Path('lab/run 1').absolute()), 'next_recording/part_*']
    assert (again.params, again.unit) == (str(tmp_path / 'my muscle.yaml'), ['displacement=mm'])
    assert again.output == str(tmp_path / 'out_2')
    assert (seen.bag, seen.params) == (again.bags[0], str(tmp_path / 'out' / 'improved.yaml'))
    page = Page(render(d, asked=asked))
    assert ''.join(page.said).count('tcp_muscle') >= 3
    assert all(not step.commands for step in steps(d, None)), 'nobody knows the paths'


def test_the_next_recording_is_made_and_read_as_the_ones_before(made, tmp_path):
    d, _ = made['convection_or_radiation']
    d = replace(d, rig=Rig(limits=RigLimits(by_person=False)))
    laser = ('--namespace', '/finger_1', '--channel', 'displacement=/laser/range.range')
    asked = Asked(
        ('run',), 'm', 'out', laser, rig='rig.yaml', separate=('B',), namespace='/finger_1', topics=('/laser/range',)
    )
    seen, played, again = [
        arguments(command) for step in steps(d, asked) for command in step.commands if 'sim_node' not in command
    ]
    assert (played.rig, again.rig) == (str(Path('rig.yaml').absolute()),) * 2
    assert (played.namespace, played.topic) == ('/finger_1', ['/laser/range'])
    assert (again.separate, again.channel, again.namespace) == (['B'], [laser[3]], '/finger_1')
    assert again.bags[1:] == ['next_recording'], 'a rig that hangs the loads plays it in one part'
    assert seen.channel == [laser[3]]


def test_in_a_workspace_of_ros_2_its_own_command_finds_the_programs(made, monkeypatch):
    monkeypatch.setattr('shutil.which', lambda name: '/opt/ros/bin/ros2' if name == 'ros2' else None)
    commands = [command for step in steps(made['match'][0], Asked(('bag',), 'm', 'out')) for command in step.commands]
    assert [command.split()[:4] for command in commands] == [
        ['ros2', 'run', 'tcp_muscle_ros', name] for name in ('tcp_muscle', 'sim_node')
    ]


def test_where_no_experiment_would_decide_the_page_says_what_would_help(made):
    d, _ = made['next_to_nothing']
    text = render(d)
    assert 'would decide' not in text and 'probability < ' not in text
    assert 'No planned experiment is likely to decide' in text and 'a second load' in text
    assert 'would help: a second load' in summary(d)


@pytest.mark.parametrize('name', ALL)
def test_nothing_that_may_be_nothing_is_called_sure(made, name):
    d, _ = made[name]
    page, terminal, data = render(d), summary(d), as_data(d)
    for finding, said in zip(d.findings, data['findings'], strict=True):
        alone = not finding.indistinguishable_from and not finding.may_be_nothing
        assert said['singled_out'] is (alone and not finding.one_channel)
        assert ('its interval includes no effect' in words.told_apart(finding)) == finding.may_be_nothing
        if finding.may_be_nothing:
            assert 'ts interval includes no effect' in page and 'its interval includes no effect' in terminal
    assert 'singled out' not in page + terminal and 'single it out' not in page


def test_every_effect_has_something_to_check_on_the_rig():
    assert [effect for effect in EFFECTS if not has_check(effect)] == []
    texts = [check_on_rig(effect) for effect in EFFECTS]
    assert len(set(texts)) == len(texts)


def test_each_finding_tells_its_own_improvement(made):
    d, _ = made['three_effects']
    said = [text for text in Page(render(d)).said if 'data kept out of the fit, without it' in text]
    assert len(said) == 3
    assert 'without it (with all others) and with it: displacement 1.90 to 0.0430 mm.' in said[0]
    assert 'temperature 1.10 to 0.160 K; displacement 0.310 to 0.0410 mm.' in said[1]


def test_where_improved_yaml_is_worse_than_the_fit_the_page_gives_both(made):
    d, _ = made['creep']
    assert 'The figures show the fit itself' not in render(d)
    stroke = replace(d.fit['displacement'], improved=2e-4, fitted=5e-5)
    d = replace(d, fit={**d.fit, 'displacement': stroke})
    (said,) = (text for text in Page(render(d)).said if 'The figures show the fit itself' in text)
    assert said.endswith('Its errors are displacement 0.0500 mm.')
    fit = as_data(d)['fit']['displacement']
    assert (fit['rmse_improved'], fit['rmse_fitted']) == (2e-4, 5e-5)


def test_one_channel_singles_nothing_out_and_the_causes_that_look_alike_are_told(made):
    d, _ = made['creep']
    cluster = (Member('creep', 'mechanical', 0.7), Member('two_node', 'thermal', 0.3))
    found = replace(d.findings[0], one_channel=True, cluster=cluster, indistinguishable_from=())
    d = replace(d, findings=(found,))
    assert not found.singled_out and as_data(d)['findings'][0]['singled_out'] is False
    assert 'one channel does not tell the stages apart' in summary(d)
    assert 'creep 0.70 (mechanical), two node 0.30 (thermal)' in render(d)
    assert [m['probability'] for m in as_data(d)['findings'][0]['cluster']] == [0.7, 0.3]
