"""The numbers that decide what is named: one file, few of them, each explained, and all of them used."""

from dataclasses import fields, replace
from pathlib import Path

import pytest
import yaml

from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.settings import policy
from tcp_muscle_ros.settings.policy import Policy, read_policy, shipped

NAMES = [field.name for field in fields(Policy)]
ENGINE = Path(policy.__file__).parents[1] / 'diagnosis'


def test_the_shipped_policy_says_of_each_number_what_it_is():
    content = yaml.safe_load(policy.SHIPPED.read_text(encoding='utf-8'))
    assert list(content) == NAMES
    assert len(NAMES) <= 25
    for name, entry in content.items():
        assert tuple(entry) == (policy.SAID if name != policy.ODDS else (*policy.SAID, policy.FITTED)), name
        assert all(str(entry[key]).strip() for key in policy.SAID), name


@pytest.mark.parametrize('name', NAMES)
def test_every_number_is_used_by_the_engine(name):
    assert any(f'policy.{name}' in path.read_text(encoding='utf-8') for path in ENGINE.rglob('*.py'))


def test_a_policy_cannot_be_changed_on_the_way():
    with pytest.raises(AttributeError):
        shipped().least_drop = 1.0
    assert replace(shipped(), least_drop=1.0).least_drop == 1.0


@pytest.mark.parametrize(
    ('change', 'said'),
    [
        (lambda c: c.pop('alike'), r'alike is None, expected a number'),
        (lambda c: c.update(alike={'value': 'much'}), r"alike is 'much', expected a number"),
        (lambda c: c.update(alik={'value': 1.0}), r"'alik' is no number of a policy; did you mean 'alike'\?"),
    ],
)
def test_what_is_wrong_with_a_policy_is_said_in_one_line(tmp_path, change, said):
    content = yaml.safe_load(policy.SHIPPED.read_text(encoding='utf-8'))
    change(content)
    path = tmp_path / 'policy.yaml'
    path.write_text(yaml.safe_dump(content), encoding='utf-8')
    with pytest.raises(BadInput, match=said) as error:
        read_policy(path)
    assert '\n' not in str(error.value)
