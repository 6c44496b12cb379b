"""The controller against a driver of your own for a real muscle. Nothing heats until it is enabled.

Read docs/hardware.md first. The driver is not started here: it takes current_command and gives the measurements.

ros2 launch tcp_muscle_ros hardware.launch.py params_file:=my_muscle.yaml current_limit_a:=0.1
ros2 service call /controller_node/enable std_srvs/srv/SetBool '{data: true}'
"""

from pathlib import Path

from tcp_muscle_ros.nodes.launching import description, node
from tcp_muscle_ros.settings.launch_arguments import number, only_for_all_nodes, parameters_of
from tcp_muscle_ros.settings.parameter_file import values_for

ARGUMENTS = [
    ('namespace', '', 'namespace of the muscle'),
    ('params_file', '', 'parameter file of this muscle under /**:, as tcp_muscle calibrate writes it'),
    ('joint_name', '', 'joint of the muscle; empty: as in the parameter file, else the last part of the namespace'),
    ('rate_hz', '', 'ticks a second of the controller; empty: as in the parameter file, else 100'),
    ('current_limit_a', '0.1', 'the most current that is ever commanded, A; start low'),
]


def start(value):
    # The last entry wins over /** of the file, and other sections say nothing of it: no parameter file can start a real
    # muscle hot, nor give one of several its own limit.
    safe = {'start_enabled': False, 'current_limit_a': number('current_limit_a', value['current_limit_a'])}
    file = value['params_file']
    if file:
        only_for_all_nodes(Path(file), 'controller_node', safe)
    muscles = values_for(Path(file), 'controller_node').get('muscles') if file else None
    prefixes = ['', *(f'{name}.' for name in muscles or [] if name)]
    parameters = parameters_of(value)
    parameters.append({prefix + name: limit for prefix in prefixes for name, limit in safe.items()})
    return [node('controller_node', value['namespace'], parameters)]


def generate_launch_description():
    return description(__file__, ARGUMENTS, start, reads={'params_file': ('controller_node',)})
