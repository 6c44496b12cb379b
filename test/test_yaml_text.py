"""What PyYAML cannot read is one line, wherever a user's YAML is read."""

import pytest

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.yaml_text import NotYaml, parse
from tcp_muscle_ros.recording.storage import custom_data
from tcp_muscle_ros.recording.yaml_input import load_yaml
from tcp_muscle_ros.settings import parameter_file

BROKEN = [
    ('{a: 1, b: 2026-13-45}', "'2026-13-45': month must be in 1..12", (1, 11)),
    ('a: 1\nb: &x {c: *x}', 'an alias (*) stands inside what it names', None),
    ('a: &x [1, [*x]]', 'an alias (*) stands inside what it names', None),
    ('a: ' + '[' * 1200, 'nested too deeply', None),
    ('a: !!int x', "'x': invalid literal for int() with base 10: 'x'", (1, 4)),
    ('a: !!bool x', "'x': not what tag:yaml.org,2002:bool is written like", (1, 4)),
    ('a: !!timestamp x', "'x': not what tag:yaml.org,2002:timestamp is written like", (1, 4)),
    ('a: [', "expected the node content, but found '<stream end>'", (1, 5)),
    ('a: \x01', 'special characters are not allowed', None),
]


@pytest.mark.parametrize(('text', 'says', 'at'), BROKEN)
def test_a_text_that_is_no_yaml_is_told_in_one_line(tmp_path, text, says, at):
    with pytest.raises(NotYaml) as problem:
        parse(text)
    assert (str(problem.value), problem.value.at) == (says, at)
    path = tmp_path / 'x.yaml'
    path.write_text(text)
    for read in (load_yaml, parameter_file.read, lambda path: parameter_file.values_for(path, 'sim_node')):
        with pytest.raises(BadInput) as refused:
            read(path)
        assert str(path) in str(refused.value)
        assert says in str(refused.value)
        assert '\n' not in str(refused.value)
    assert custom_data(text) == {}


def test_what_is_named_twice_is_there_twice():
    assert parse('a: &x {b: [1]}\nc: [*x, *x]') == {'a': {'b': [1]}, 'c': [{'b': [1]}, {'b': [1]}]}


def test_a_whole_number_beyond_all_others_is_refused_in_one_line(tmp_path):
    (tmp_path / 'muscle.yaml').write_text(f'/**:\n  ros__parameters:\n    hA: 1{"0" * 400}\n')
    with pytest.raises(BadInput, match="parameter 'hA' = inf: expected a finite number"):
        parameter_file.read(tmp_path / 'muscle.yaml')


def test_a_tab_in_place_of_spaces_is_said_to_be_one():
    with pytest.raises(NotYaml, match='a tab, which YAML does not take as an indent: put spaces') as raised:
        parse('/**:\n  ros__parameters:\n\thA: 0.02\n')
    assert raised.value.at == (3, 1)
