"""A simulated muscle.

ros2 launch tcp_muscle_ros sim.launch.py namespace:=finger_1 params_file:=muscle.yaml rate_hz:=200
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import Node

from tcp_muscle_ros.settings.launch_arguments import joint_of, number, read_arguments

ARGUMENTS = [
    ('namespace', '', 'namespace of the muscle; several muscles stand side by side in several namespaces'),
    ('params_file', '', 'parameter file under /**:, for example what tcp_muscle calibrate wrote'),
    ('joint_name', '', 'joint of the muscle; empty: as in the parameter file, else the last part of the namespace'),
    ('rate_hz', '', 'ticks a second; empty: as in the parameter file, else 100'),
    ('real_time_factor', '', 'simulated over real time, 0 as fast as possible; empty: as in the file, else 1'),
]


def nodes(context):
    value = read_arguments(__file__, ARGUMENTS, context.launch_configurations, nodes=('sim_node',))
    parameters = [value['params_file']] if value['params_file'] else []
    numbers = {name: number(name, value[name]) for name in ('rate_hz', 'real_time_factor') if value[name]}
    if numbers:
        parameters.append(numbers)
    if joint := joint_of(value, 'sim_node'):
        parameters.append(joint)
    return [
        Node(
            package='tcp_muscle_ros',
            executable='sim_node',
            namespace=value['namespace'],
            parameters=parameters,
            output='screen',
        )
    ]


def generate_launch_description():
    declared = [DeclareLaunchArgument(name, default_value=value, description=text) for name, value, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
