"""Two simulated muscles on one joint, and the controller of its angle and co-contraction.

ros2 launch tcp_muscle_ros antagonist.launch.py
ros2 topic pub -r 10 /knuckle/angle_setpoint std_msgs/msg/Float64 '{data: 0.5}'
ros2 topic pub -r 10 /knuckle/cocontraction_setpoint std_msgs/msg/Float64 '{data: 0.8}'
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from tcp_muscle_ros.settings.launch_arguments import number, read_arguments

ARGUMENTS = [
    ('namespace', '', 'namespace of the joint and its muscles'),
    ('params_file', '', 'parameter file with muscles and joint, shared by both nodes; empty: config/antagonist.yaml'),
    ('rate_hz', '', 'ticks a second of both nodes; empty: as in the parameter file, else 100'),
]


def nodes(context):
    value = read_arguments(__file__, ARGUMENTS, context.launch_configurations, nodes=('sim_node', 'controller_node'))
    own = PathJoinSubstitution([FindPackageShare('tcp_muscle_ros'), 'config', 'antagonist.yaml'])
    parameters = [value['params_file'] or own]
    if value['rate_hz']:
        parameters.append({'rate_hz': number('rate_hz', value['rate_hz'])})
    return [
        Node(
            package='tcp_muscle_ros',
            executable=executable,
            namespace=value['namespace'],
            parameters=parameters,
            output='screen',
        )
        for executable in ('sim_node', 'controller_node')
    ]


def generate_launch_description():
    declared = [DeclareLaunchArgument(name, default_value=value, description=text) for name, value, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
