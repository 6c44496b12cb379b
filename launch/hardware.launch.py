"""The controller against a driver of your own for a real muscle. Nothing heats until it is enabled.

Read docs/hardware.md first. The driver is not started here: it takes current_command and gives the measurements.

ros2 launch tcp_muscle_ros hardware.launch.py params_file:=my_muscle.yaml current_limit_a:=0.1
ros2 service call /controller_node/enable std_srvs/srv/SetBool '{data: true}'
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import Node

from tcp_muscle_ros.settings.launch_arguments import joint_of, number, read_arguments
from tcp_muscle_ros.settings.parameter_file import values_for

ARGUMENTS = [
    ('namespace', '', 'namespace of the muscle'),
    ('params_file', '', 'parameter file of this muscle under /**:, as tcp_muscle calibrate writes it'),
    ('joint_name', '', 'joint of the muscle; empty: as in the parameter file, else the last part of the namespace'),
    ('rate_hz', '', 'ticks a second of the controller; empty: as in the parameter file, else 100'),
    ('current_limit_a', '0.1', 'the most current that is ever commanded, A; start low'),
]


def nodes(context):
    value = read_arguments(__file__, ARGUMENTS, context.launch_configurations, nodes=('controller_node',))
    # The last entry wins: no parameter file can start a real muscle hot, nor give one of several its own limit.
    safe = {'start_enabled': False, 'current_limit_a': number('current_limit_a', value['current_limit_a'])}
    file = value['params_file']
    muscles = values_for(Path(file), 'controller_node').get('muscles') if file else None
    prefixes = ['', *(f'{name}.' for name in muscles or [] if name)]
    parameters = [file] if file else []
    if joint := joint_of(value, 'controller_node'):
        parameters.append(joint)
    if value['rate_hz']:
        parameters.append({'rate_hz': number('rate_hz', value['rate_hz'])})
    parameters.append({prefix + name: limit for prefix in prefixes for name, limit in safe.items()})
    return [
        Node(
            package='tcp_muscle_ros',
            executable='controller_node',
            namespace=value['namespace'],
            parameters=parameters,
            output='screen',
        )
    ]


def generate_launch_description():
    declared = [DeclareLaunchArgument(name, default_value=value, description=text) for name, value, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
