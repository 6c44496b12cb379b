"""``tcp_muscle run`` before a muscle is asked: what it refuses, and what becomes of a run that is there already."""

import json

import pytest

from tcp_muscle_ros.commands import run as command
from tcp_muscle_ros.commands.run_log import RunLog, admit_output, path_of
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.nodes.runner import Played
from tcp_muscle_ros.recording.protocol import read_protocol
from tcp_muscle_ros.settings.intervals import SCHEMA, path_beside
from tcp_muscle_ros.settings.parameter_file import write
from tcp_muscle_ros.tool import main

PROTOCOL = 'rate_hz: 20\ninput: current\nsegments:\n  - {duration_s: 5, value: %s, load_n: 0.3}\n'


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """``tcp_muscle run`` up to the end of its gate; returns (exit code, what was said)."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'protocol.yaml').write_text(PROTOCOL % '0.1')

    def run(*options, output='bag'):
        code = main(['run', 'protocol.yaml', '--yes', '--output', output, *options], until_admitted=True)
        return code, capsys.readouterr().err

    return run


def bag(path, content='old'):
    path.mkdir(parents=True)
    (path / 'metadata.yaml').write_text(content)
    (path / f'{path.name}_0.mcap').write_text(content)


def test_what_is_there_is_replaced_only_by_force(run, tmp_path):
    assert run() == (0, '')
    bag(tmp_path / 'bag')
    code, said = run()
    assert code == 2 and 'bag: exists already and is not overwritten; give another --output, or --force' in said
    assert run('--force') == (0, '')
    (tmp_path / 'new.run.json').write_text('mine')
    code, said = run(output='new')
    assert code == 2 and 'new.run.json: exists already and is not overwritten' in said
    assert run('--force', output='new') == (0, '')
    (tmp_path / 'bag' / 'notes.txt').write_text('mine')
    code, said = run('--force')
    assert code == 2 and '--force replaces nothing else' in said
    code, said = run('--force', output='protocol.yaml')
    assert code == 2 and 'nothing that is read is overwritten' in said


@pytest.mark.parametrize(
    ('value', 'options', 'told'),
    [
        ('0.6', (), 'above the 100.0 degC of the usual derating temperature'),
        ('1e200', (), 'current is 1e+200, expected 0 to 1000 A, as sim_node'),
        ('900', (), 'the model has no finite answer'),
        ('0.1', ('--rig', 'weak.yaml'), 'asks for 0.1 A, above the limit of 0.05 A of rig.yaml'),
        ('0.1', ('--rig', 'rig.yaml'), 'asks for a load of 0.3 N, which the rig has not; nearest 0.5 N'),
        ('0.1', ('--resume',), '--resume: bag.run.json does not exist'),
        ('0.1', ('--resume', '--force'), 'expected one of them'),
    ],
)
def test_what_may_not_be_played_is_refused_before_a_muscle_is_asked(run, tmp_path, value, options, told):
    (tmp_path / 'protocol.yaml').write_text(PROTOCOL % value)
    (tmp_path / 'rig.yaml').write_text('limits: {loads_n: [0.5]}\n')
    (tmp_path / 'weak.yaml').write_text('limits: {largest_current_a: 0.05}\n')
    code, said = run(*options)
    assert code == 2 and said.count('\n') == 1 and told in said
    assert not (tmp_path / 'bag').exists()


@pytest.mark.parametrize(
    ('content', 'told'),
    [
        ('[]', 'is no log of a run'),
        ('{"schema": "tcp_muscle_ros/run-1", "protocol": "another", "parts": {}}', 'is of another protocol'),
    ],
)
def test_only_a_run_of_the_same_protocol_is_resumed(run, tmp_path, content, told):
    (tmp_path / 'bag.run.json').write_text(content)
    code, said = run('--resume')
    assert code == 2 and told in said


@pytest.fixture
def replacing(run, tmp_path):
    """The log of a run that is to replace a bag and its log."""
    bag(tmp_path / 'bag')
    path_of(tmp_path / 'bag').write_text('old')
    protocol = read_protocol(tmp_path / 'protocol.yaml')
    before = admit_output(tmp_path / 'bag', protocol, resume=False, force=True)
    return RunLog(tmp_path / 'bag', protocol, 1, before)


def names(folder):
    return sorted(path.name for path in folder.iterdir() if path.name != 'protocol.yaml')


def test_a_run_that_recorded_nothing_leaves_what_was_there(replacing, tmp_path):
    replacing.begin(1)
    assert replacing.end() is None
    assert names(tmp_path) == ['bag', 'bag.run.json']
    assert path_of(tmp_path / 'bag').read_text() == (tmp_path / 'bag' / 'metadata.yaml').read_text() == 'old'


def test_what_was_there_is_kept_until_the_run_is_complete(replacing, tmp_path):
    bag(replacing.begin(1), 'new')
    replacing.write(1, Played('interrupted', (0.0,)))
    assert replacing.end() == tmp_path / 'bag_before_1'
    assert (tmp_path / 'bag_before_1' / 'metadata.yaml').read_text() == 'old'
    protocol = read_protocol(tmp_path / 'protocol.yaml')
    resumed = RunLog(tmp_path / 'bag', protocol, 1, admit_output(tmp_path / 'bag', protocol, resume=True, force=False))
    bag(resumed.begin(1), 'newer')
    resumed.write(1, Played('', (0.0,)))
    assert resumed.end() is None
    assert names(tmp_path) == ['bag', 'bag.run.json', 'bag_stopped_1']
    assert (tmp_path / 'bag' / 'metadata.yaml').read_text() == 'newer'
    assert json.loads((tmp_path / 'bag.run.json').read_text())['parts']['1']['complete']


def test_a_log_that_cannot_be_written_is_one_line(replacing, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr('pathlib.Path.write_text', full)
    with pytest.raises(BadInput, match=r'bag\.run\.json: cannot be written \(No space left on device\)'):
        replacing.begin(1)


class Silent:
    """A runner under whose namespace nothing answers, or which is stopped before it has played."""

    def __init__(self, error):
        self.error = error

    def __call__(self, *_):
        return self

    def __enter__(self):
        raise self.error

    def __exit__(self, *_):
        pass


def test_where_no_muscle_answers_it_is_said_where_there_are_some(run, tmp_path, monkeypatch, capsys):
    rclpy = pytest.importorskip('rclpy')
    from std_msgs.msg import Float64

    context = rclpy.context.Context()
    rclpy.init(args=[], context=context)
    node = rclpy.create_node('one', context=context)
    publishers = [node.create_publisher(Float64, f'/finger_{k}/displacement', 1) for k in (1, 2)]
    monkeypatch.setattr(command, '_runner_class', lambda: Silent(BadInput('under / no muscle answers within 10 s')))
    try:
        assert main(['run', 'protocol.yaml', '--yes', '--output', 'bag']) == 2
        said = capsys.readouterr().err
        assert said.startswith('tcp_muscle run: under / no muscle answers within 10 s; there are muscles under /')
        assert '/finger_1, /finger_2' in said and said.count('\n') == 1
        assert main(['run', 'protocol.yaml', '--yes', '--output', 'bag', '--namespace', 'finger_1']) == 2
        assert capsys.readouterr().err.endswith('within 10 s\n')
    finally:
        del publishers
        node.destroy_node()
        rclpy.shutdown(context=context)


@pytest.mark.parametrize(('fixed', 'warned'), [(True, False), (False, True), (None, False)])
def test_no_temperature_is_vouched_for_that_the_recordings_did_not_fix(
    run, tmp_path, monkeypatch, capsys, fixed, warned
):
    """``fixed``: what the intervals beside the parameter file say of hA; None: there are none."""
    write(tmp_path / 'improved.yaml', Parameters({'hA': 0.8, 'C': 3.6}))
    if fixed is not None:
        told = {'schema': SCHEMA, 'parameters': [{'name': 'hA', 'fixed_by_data': fixed}]}
        path_beside(tmp_path / 'improved.yaml').write_text(json.dumps(told))
    monkeypatch.setattr(command, '_runner_class', lambda: Silent(BadInput('under / no muscle answers within 10 s')))
    assert main(['run', 'protocol.yaml', '--yes', '--output', 'bag', '--params', 'improved.yaml']) == 2
    said = capsys.readouterr().out
    assert (
        'warning: improved.yaml: its recordings did not fix hA, so the muscle may become far hotter' in said
    ) == warned


def test_stopped_before_anything_was_played_no_bag_is_claimed(run, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(command, '_runner_class', lambda: Silent(KeyboardInterrupt()))
    assert main(['run', 'protocol.yaml', '--yes', '--output', 'bag']) == 130
    assert capsys.readouterr().out.endswith('bag: interrupted before anything was played; no bag was written\n')
    assert not (tmp_path / 'bag').exists()


def test_a_run_is_continued_in_the_parts_that_it_was_begun_in(run, tmp_path):
    """With a person the first of two parts was done; without one there is but one part, and it was called done."""
    protocol = read_protocol(tmp_path / 'protocol.yaml')
    begun = RunLog(tmp_path / 'bag', protocol, 2)
    begun.begin(1)
    begun.write(1, Played('', (0.0,)))
    before = admit_output(tmp_path / 'bag', protocol, resume=True, force=False)
    assert RunLog(tmp_path / 'bag', protocol, 2, before).done(1)
    with pytest.raises(BadInput, match='was begun in 2 parts, which would be 1 now'):
        RunLog(tmp_path / 'bag', protocol, 1, before)
