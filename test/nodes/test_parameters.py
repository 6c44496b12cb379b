"""The nodes' parameters: from the tables, and every mistake answered by one line and exit code 2."""

import os
import signal
import subprocess
import sys
from math import inf, nan

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

import rclpy
from rclpy.parameter import Parameter

from tcp_muscle_ros.control import tracking
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.nodes.declaring import declare
from tcp_muscle_ros.nodes.parameters import KNOWN, descriptor, read, read_effects, read_value
from tcp_muscle_ros.settings.operating import CONTROL, OPERATING, SIM, TWIN, TWIN_NODE
from tcp_muscle_ros.settings.parameter_file import write


def test_without_overrides_the_muscle_is_set_a():
    assert read({}, SIM).muscle().vector.tolist() == Parameters.named('karami_tadesse_2017').vector.tolist()


def test_a_rig_is_what_the_instruments_show_and_a_wrong_one_is_one_line(tmp_path):
    path = tmp_path / 'rig.yaml'
    path.write_text('instruments: {temperature: {lag_s: 1.5}}\n')
    muscle = read({'rig_file': str(path)}, SIM).muscle()
    assert 'thermocouple_lag' in muscle.effects
    assert muscle['thermocouple_lag.tau'] == 1.5
    assert read({'rig_file': str(path)}, CONTROL).muscle().effects == ()
    path.write_text('instruments: {temprature: {lag_s: 1.5}}\n')
    with pytest.raises(BadInput, match='temperature'):
        read({'rig_file': str(path)}, SIM).muscle()


@pytest.mark.parametrize(
    ('name', 'stays'),
    [
        ('hysteresis.law', True),
        ('clock_skew.channel', True),
        ('free_delay.stage', True),
        ('free_slow_state.driver', True),
        ('free_resistance.driver', False),  # without states there is nothing to misread
        ('hysteresis.w', False),
        ('mode', False),
    ],
)
def test_which_law_an_effect_follows_stays_as_long_as_the_node_runs(name, stays):
    """The states of one law are not those of another: a late temperature, read as a current, melts the muscle."""
    assert descriptor(KNOWN[name]).read_only is stays


def test_every_default_is_within_its_own_bounds_and_has_a_descriptor():
    for name, row in KNOWN.items():
        assert read_value(row, row.default) == row.default, name
        described = descriptor(row)
        assert described.name == name and described.description
        for limits in described.floating_point_range:
            assert limits.from_value <= row.default <= limits.to_value, name


def test_the_controllers_defaults_are_those_of_the_control_law():
    settings = tracking.Settings()
    for name, parameter in (
        ('mode', 'mode'),
        ('time_constant', 'time_constant_s'),
        ('probe_current', 'probe_current_a'),
        ('pid_kp', 'pid_kp_a_per_m'),
        ('pid_ki', 'pid_ki_a_per_m_s'),
        ('pid_kd', 'pid_kd_a_s_per_m'),
        ('pid_filter_time', 'pid_filter_time_s'),
    ):
        assert OPERATING[parameter].default == getattr(settings, name), parameter


def test_temperatures_are_in_celsius_outside_and_kelvin_inside():
    settings = read({'T0': 20.0, 'max_temperature_c': 110.0}, SIM)
    assert settings.muscle()['T0'] == 293.15
    assert settings.kelvin('max_temperature_c') == pytest.approx(383.15)


def test_a_whole_number_is_taken_for_a_decimal_and_a_whole_decimal_for_a_number():
    settings = read({'hA': 1, 'seed': 3.0}, SIM)
    assert settings['hA'] == 1.0 and type(settings['hA']) is float
    assert settings['seed'] == 3 and type(settings['seed']) is int


def test_initial_temperature_follows_the_ambient_unless_given():
    assert read({'ambient_temperature_c': 30.0}, SIM)['initial_temperature_c'] == 30.0
    assert read({'ambient_temperature_c': 30.0, 'initial_temperature_c': 50.0}, SIM)['initial_temperature_c'] == 50.0


def test_the_other_nodes_names_and_effects_that_are_off_are_left_alone():
    given = {'mode': 'pid', 'seed': 1, 'creep.J': 0.1, 'use_sim_time': True, 'qos_overrides./clock.depth': 3}
    assert 'mode' not in read(given, SIM) and 'seed' not in read(given, CONTROL)
    assert 'creep.J' not in read(given, SIM)
    assert read({**given, 'effects': ['creep']}, SIM)['creep.J'] == 0.1


@pytest.mark.parametrize('nothing', [None, [], [''], ()])
def test_no_effects_can_be_said_in_several_ways(nothing):
    assert read_effects(nothing) == ()


@pytest.mark.parametrize(
    ('given', 'line'),
    [
        ({'ha': 0.02}, "unknown parameter 'ha'; did you mean 'hA'?"),
        ({'current_limit': 0.2}, "unknown parameter 'current_limit'; did you mean 'current_limit_a'?"),
        ({'effects': ['kreep']}, "parameter 'effects': unknown effect 'kreep'; did you mean 'creep'?"),
        ({'effects': 'creep'}, "parameter 'effects' is 'creep'; expected a list of names"),
        ({'hA': nan}, "parameter 'hA' is nan; expected 1e-05 to 10 W/K"),
        ({'hA': inf}, "parameter 'hA' is inf; expected"),
        ({'hA': 'warm'}, "parameter 'hA' is 'warm'; expected"),
        ({'hA': True}, "parameter 'hA' is true; expected"),
        ({'hA': [1.0]}, "parameter 'hA' is [1.0]; expected"),
        ({'T0': 296.15}, "parameter 'T0' is 296.15; expected -23.15 to 76.85 degC"),
        ({'ambient_temperature_c': 296.15}, "'ambient_temperature_c' is 296.15; expected -40 to 100 degC"),
        ({'max_temperature_c': 388.15}, "'max_temperature_c' is 388.15; expected -40 to 250 degC"),
        ({'current_limit_a': 270.0}, "'current_limit_a' is 270; expected 0 to 100 A"),
        ({'L0': 500.0}, "parameter 'L0' is 500; expected 0.001 to 50 m"),
        ({'seed': 1.5}, "parameter 'seed' is 1.5; expected a whole number"),
        ({'start_enabled': 1}, "parameter 'start_enabled' is 1; expected true or false"),
        ({'end': 'blockd'}, "parameter 'end' is 'blockd'; did you mean 'blocked'?"),
        ({'mode': 'pdi'}, "parameter 'mode' is 'pdi'; did you mean 'pid'?"),  # the other node's mistake is one too
        ({'rate_hz': 5000.0}, "parameter 'rate_hz' is 5000; expected 1 to 2000 Hz"),
    ],
)
def test_a_mistake_is_answered_by_one_line_that_helps(given, line):
    with pytest.raises(BadInput) as caught:
        read(given, SIM)
    assert line in str(caught.value) and '\n' not in str(caught.value)


FILES = {
    'broken.yaml': '/**:\n  ros__parameters:\n    hA: [0.02\n    k0: {\n',
    'date.yaml': '/**:\n  ros__parameters:\n    hA: 2026-13-45\n',
    'empty.yaml': '',
    'other.yaml': 'hA: 0.02\n',
    'misspelt.yaml': '/**:\n  ros__parameters:\n    hA_w_per_k: 0.02\n',
    'nan.yaml': '/**:\n  ros__parameters:\n    k0: .nan\n',
    'whole.yaml': '/**:\n  ros__parameters:\n    current_limit_a: 1\n',
    'text.yaml': '/**:\n  ros__parameters:\n    hA: warm\n',
    'twice.yaml': '/**:\n  ros__parameters:\n    current_limit_a: 0.1\n    current_limit_a: 0.2\n',
    'quoted.yaml': '/**:\n  ros__parameters:\n    current_limit_a: "0,1"\n',
}


@pytest.mark.processes
@pytest.mark.parametrize(
    ('program', 'arguments', 'line'),
    [
        ('sim_node', ['--params-file', 'broken.yaml'], 'broken.yaml: does not parse as YAML in line 4'),
        ('sim_node', ['--params-file', 'date.yaml'], "in line 3, column 9: '2026-13-45': month must be in 1..12"),
        ('controller_node', ['--params-file', 'empty.yaml'], "empty.yaml: no parameters; expected '/**:'"),
        ('sim_node', ['--params-file', 'other.yaml'], "other.yaml: no parameters; expected '/**:'"),
        ('sim_node', ['--params-file', 'missing.yaml'], 'missing.yaml: cannot read'),
        ('controller_node', ['--params-file', 'misspelt.yaml'], "unknown parameter 'hA_w_per_k'"),
        ('sim_node', ['--params-file', 'nan.yaml'], "parameter 'k0' is nan; expected 0.01 to"),
        ('sim_node', ['--params-file', 'text.yaml'], "parameter 'hA' is 'warm'; expected"),
        ('sim_node', ['--params-file', 'twice.yaml'], "in line 4, column 5: 'current_limit_a' stands there twice"),
        ('sim_node', ['--params-file', 'quoted.yaml'], "'current_limit_a' is '0,1'; expected a number, 0 to 100 A"),
        ('sim_node', ['foo'], "argument 'foo' is not understood; see sim_node --help"),
        (
            'controller_node',
            ['--params-file', 'whole.yaml', '-p', 'current_limit_a:=0.1'],
            "parameter 'current_limit_a' is given both as a whole number and as a decimal",
        ),
        ('sim_node', ['-p', 'max_temperature_c:=80.0'], 'derating must begin below the maximum temperature'),
        ('sim_node', ['-p', 'end:=spring'], 'spring_rate_n_per_m is 0.0: a muscle'),
        ('sim_node', ['-p', 'real_time_factor:=2.0', '-p', 'use_sim_time:=true'], 'cannot publish /clock and follow'),
        ('sim_node', ['-p', 'qos_overrides./load.subscription.reliability:=relible'], "did you mean 'reliable'?"),
        ('sim_node', ['-p', 'qos_overrides./load.subscription.depth:=0'], 'expected a whole number, 1 to 100000'),
        ('sim_node', ['-r', '__ns:=/1muscle'], 'sim_node: '),
        ('sim_node', ['--parameters', 'x.yaml'], 'sim_node: '),
        ('sim_node', ['--', '-p', 'current_limit_a:=0.1'], "argument '-p' is not understood; expected arguments of"),
    ],
)
def test_a_process_given_a_mistake_ends_with_2_and_one_line(tmp_path, program, arguments, line):
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    ended = subprocess.run(
        [sys.executable, '-m', f'tcp_muscle_ros.nodes.{program}', '--ros-args', *arguments],
        cwd=tmp_path,
        # The home in which the model is compiled already: in another it would be compiled again.
        env={**os.environ, 'PYTHONPATH': ':'.join(filter(None, sys.path))},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert ended.returncode == 2, ended.stderr
    assert line in ended.stderr
    assert ended.stderr.count('\n') == 1 and ended.stdout == '', ended.stderr


@pytest.mark.parametrize(
    ('given', 'told'),
    [
        (
            {'natural_convection.n': 0.3},
            ['natural_convection.n has no effect: natural_convection is not among effects: []'],
        ),
        ({'natural_convection.n': 0.3, 'effects': ['natural_convection']}, []),
        (
            {'muscles': ['a', 'b'], 'a.effects': ['creep'], 'creep.J': 0.1, 'b.creep.J': 0.2},
            ['b: creep.J has no effect: creep is not among effects: []'],
        ),
    ],
)
def test_a_parameter_of_an_effect_that_is_not_on_is_warned_of(monkeypatch, given, told):
    context = rclpy.context.Context()
    rclpy.init(args=[], context=context)
    overrides = [Parameter(name, value=value) for name, value in given.items()]
    node = rclpy.create_node('one', context=context, parameter_overrides=overrides)
    said = []
    try:
        monkeypatch.setattr(type(node.get_logger()), 'warning', lambda _, sentence: said.append(sentence))
        declare(node, SIM, lambda _: None, lambda *_: None)
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
    assert said == told


@pytest.mark.parametrize(
    ('section', 'more', 'idle'),
    [
        ('/**', [], False),
        ('sim_node', [], False),
        ('simnode', [], True),
        ('/finger/sim_node', [], True),
        ('/finger/sim_node', ['-r', '__ns:=/finger'], False),
        ('/**/sim_node', ['-r', '__ns:=/hand/finger'], False),
        ('/*/sim_node', ['-r', '__ns:=/hand/finger'], True),
        ('sim_node', ['-r', '__ns:=/finger'], True),
        ('thumb', ['-r', '__node:=thumb'], False),
        ('controller_node', [], True),
    ],
)
def test_a_file_of_which_ros_takes_nothing_is_named(tmp_path, section, more, idle):
    from tcp_muscle_ros.nodes.arguments import idle_files

    (tmp_path / 'x.yaml').write_text(f'{section}:\n  ros__parameters:\n    current_limit_a: 0.1\n')
    told = idle_files(['sim_node', '--ros-args', '--params-file', str(tmp_path / 'x.yaml'), *more], 'sim_node')
    assert len(told) == idle and all('nothing in it is for /' in sentence for sentence in told)


@pytest.mark.parametrize(
    ('arguments', 'line'),
    [
        (
            ['-p', 'current_limit_a:=0.1'],
            "argument '-p' is not understood; expected arguments of ROS: sim_node --ros-args ",
        ),
        (['--ros-args', '-p', 'seed:=3', '--', 'fast'], "argument 'fast' is not understood"),
        (['current_limit_a:=0.1'], "argument 'current_limit_a:=0.1' is not understood"),
    ],
)
def test_an_argument_that_ros_would_leave_alone_is_refused(arguments, line):
    from tcp_muscle_ros.nodes.arguments import refuse_leftover

    with pytest.raises(BadInput) as caught:
        refuse_leftover(['sim_node', *arguments], SIM)
    assert line in str(caught.value)
    refuse_leftover(['sim_node', '--ros-args', '-p', 'current_limit_a:=0.1', '-r', '__ns:=/a', '--'], SIM)


@pytest.mark.parametrize('node', [SIM, CONTROL])
def test_help_answers_with_the_nodes_own_parameters(node, capsys):
    from tcp_muscle_ros.nodes.arguments import usage
    from tcp_muscle_ros.nodes.lifetime import run

    handlers = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    try:
        assert run(lambda: pytest.fail('a node was made'), node, [node, '--help']) == 0
    finally:
        for number, handler in zip((signal.SIGINT, signal.SIGTERM), handlers, strict=True):
            signal.signal(number, handler)
    said = capsys.readouterr().out
    assert said.strip() == usage(node)
    assert '5883989999' not in said
    assert 'current_limit_a' in said and ('mode ' in said) == (node == CONTROL) and ('seed ' in said) == (node == SIM)
    assert '0.27 A' in said


def test_help_of_the_twin_lists_its_parameters():
    from tcp_muscle_ros.nodes.arguments import usage

    assert '(0.0 K)' in usage('sim_node') and '(0.0 N)' in usage('sim_node')
    said = usage(TWIN_NODE)
    assert all(f'  {name} ' in said for name in TWIN)
    assert 'how much of warm muscle two models are compared on (60.0 s)' in said
    assert 'current_limit_a' not in said


@pytest.mark.parametrize('value', ['2026-13-45', '&x [*x]', '[' * 3000, '['])
def test_a_value_that_is_no_yaml_is_left_to_ros(value):
    from tcp_muscle_ros.nodes.arguments import check_arguments

    check_arguments(['-p', f'seed:={value}', '-p', 'seed:=4'], SIM)


def test_two_decimals_or_the_last_of_two_files_are_no_contradiction(tmp_path):
    from tcp_muscle_ros.nodes.arguments import check_arguments

    (tmp_path / 'a.yaml').write_text('/**:\n  ros__parameters:\n    current_limit_a: 1.0\n    seed: 3\n')
    (tmp_path / 'b.yaml').write_text('finger:\n  other_node:\n    ros__parameters:\n      current_limit_a: 1\n')
    given = ['--ros-args', '--params-file', str(tmp_path / 'a.yaml'), '--params-file', str(tmp_path / 'b.yaml')]
    check_arguments([*given, '-p', 'current_limit_a:=1e-1', '-p', 'other_node:seed:=2.0', '-p', 'seed:=4'], SIM)


def section(pattern, value):
    return f"'{pattern}': {{ros__parameters: {{current_limit_a: {value}}}}}\n"


def as_ros_takes(arguments, name='current_limit_a'):
    context = rclpy.Context()
    context.init(args=arguments)
    node = rclpy.create_node(SIM, context=context, automatically_declare_parameters_from_overrides=True)
    try:
        return node.get_parameter_or(name).value
    finally:
        node.destroy_node()
        context.shutdown()


FIRST, LAST = section('/**', 0.3), section('/**', 0.1)
OPTION, FINGER, THUMB = ['-p', 'current_limit_a:=0.1'], ['-r', '__ns:=/finger'], ['-r', f'{SIM}:__node:=thumb']


@pytest.mark.parametrize(
    ('texts', 'more', 'counts'),
    [
        ([FIRST + section('sim_node', 0.2)], OPTION, False),
        ([FIRST + section('/sim_node', 0.2)], OPTION, False),
        ([FIRST + section('sim_node', 0.2)], ['-p', 'sim_node:current_limit_a:=0.1'], True),
        (
            [FIRST + section('sim_node', 0.4) + section('/sim_node', 0.2)],
            ['-p', 'sim_node:current_limit_a:=0.1'],
            False,
        ),
        ([FIRST + section('sim_node', 0.1)], OPTION, True),  # the same
        ([section('sim_node', 0.2)], OPTION, True),  # /** comes after it
        ([section('sim_node', 0.2) + FIRST], OPTION, True),
        ([FIRST + section('other_node', 0.2)], OPTION, True),
        ([FIRST + section('sim_node', 0.1)], [], True),
        ([FIRST, section('sim_node', 0.1)], [], True),
        ([FIRST + section('/**/sim_node', 0.2), LAST], [], False),
        ([FIRST + section('**', 0.2), LAST], [], False),
        ([FIRST + section('/*', 0.2), LAST], [], False),
        ([FIRST + section('/*/*', 0.2), LAST], [], True),
        ([FIRST + section('/*/*', 0.2), LAST], FINGER, False),
        ([FIRST + section('sim_node', 0.2), LAST], FINGER, True),
        ([FIRST + f'finger: {{{section("sim_node", 0.2).strip()}}}', LAST], FINGER, False),
        ([FIRST, section('finger/sim_node', 0.2), LAST], FINGER, False),
        ([FIRST + section('/finger/sim_node', 0.2), LAST], [*FINGER, '-r', '__ns:=/b'], False),
        ([FIRST + section('thumb', 0.2), LAST], ['-r', '__node:=thumb'], False),
        ([FIRST + section('thumb', 0.2)], THUMB + OPTION, False),
        ([FIRST + section('thumb', 0.2)], ['-r', '__name:=thumb', *OPTION], False),
    ],
)
def test_a_value_given_last_counts_or_is_refused(tmp_path, texts, more, counts):
    from tcp_muscle_ros.nodes.arguments import check_arguments

    arguments = [SIM, '--ros-args']
    for number, text in enumerate(texts):
        (tmp_path / f'{number}.yaml').write_text(text)
        arguments += ['--params-file', str(tmp_path / f'{number}.yaml')]
    arguments += more
    assert as_ros_takes(arguments) == (0.1 if counts else 0.2), 'this is how ROS is'
    if counts:
        check_arguments(arguments, SIM)
        return
    with pytest.raises(BadInput, match=r"^parameter 'current_limit_a' = 0\.1 \(.*\) would not count: ROS takes 0\.2, "):
        check_arguments(arguments, SIM)


def test_what_is_to_be_written_instead_is_said(tmp_path):
    from tcp_muscle_ros.nodes.arguments import check_arguments

    file = tmp_path / 'mine.yaml'
    file.write_text(
        "'/**': {ros__parameters: {load_n: 0.5}}\n'/**/sim_node': {ros__parameters: {start_enabled: true}}\n"
    )
    given = ['--ros-args', '--params-file', str(file), '-p', 'start_enabled:=false']
    for more, instead in (([], f', or write -p {SIM}:start_enabled:=false'), (FINGER, '')):
        with pytest.raises(BadInput) as caught:
            check_arguments([*given, *more], SIM)
        assert str(caught.value) == (
            "parameter 'start_enabled' = false (-p start_enabled:=false) would not count: ROS takes true, which is "
            f"below '/**/sim_node' ({file}); take it out there{instead}"
        )


@pytest.mark.parametrize(
    'text', ['', '7', 'on', 'y', 'null', 'inf', '0x10', 'a: b', 'tty #1', 'a "b"', 'ü\n\u2028💪', 'thumb']
)
def test_a_text_that_is_written_to_a_file_is_the_same_to_ros(tmp_path, text):
    write(tmp_path / 'm.yaml', Parameters.named('karami_tadesse_2017'), names=[], operating={'joint_name': text})
    assert as_ros_takes([SIM, '--ros-args', '--params-file', str(tmp_path / 'm.yaml')], 'joint_name') == text
