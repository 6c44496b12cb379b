"""A hand of sixteen simulated muscles in one process, and their controllers in another.

ros2 launch tcp_muscle_ros hand.launch.py
ros2 topic pub -r 10 /thumb_flexor/displacement_setpoint std_msgs/msg/Float64 '{data: 0.02}'
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from tcp_muscle_ros.settings.launch_arguments import number, read_arguments, switch

ARGUMENTS = [
    ('namespace', '', 'namespace of the hand: left/thumb_flexor/temperature'),
    ('params_file', '', 'parameter file with the list of muscles, shared by both nodes; empty: config/hand.yaml'),
    ('rate_hz', '', 'ticks a second of both nodes; empty: as in the parameter file'),
    ('controller', 'true', 'false: the muscles alone, driven through current_command'),
]


def nodes(context):
    value = read_arguments(__file__, ARGUMENTS, context.launch_configurations, nodes=('sim_node', 'controller_node'))
    own = PathJoinSubstitution([FindPackageShare('tcp_muscle_ros'), 'config', 'hand.yaml'])
    parameters = [value['params_file'] or own]
    if value['rate_hz']:
        parameters.append({'rate_hz': number('rate_hz', value['rate_hz'])})
    executables = ['sim_node', 'controller_node'] if switch('controller', value['controller']) else ['sim_node']
    return [
        Node(
            package='tcp_muscle_ros',
            executable=executable,
            namespace=value['namespace'],
            parameters=parameters,
            output='screen',
        )
        for executable in executables
    ]


def generate_launch_description():
    declared = [DeclareLaunchArgument(name, default_value=value, description=text) for name, value, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
