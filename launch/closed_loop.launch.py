"""A simulated muscle and its position controller, from one parameter file.

ros2 launch tcp_muscle_ros closed_loop.launch.py
ros2 topic pub -r 10 /displacement_setpoint std_msgs/msg/Float64 '{data: 0.02}'
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import Node

from tcp_muscle_ros.settings.launch_arguments import joint_of, number, read_arguments

ARGUMENTS = [
    ('namespace', '', 'namespace of the muscle and of its controller'),
    ('params_file', '', 'parameter file under /**:, shared by both nodes'),
    ('joint_name', '', 'joint of the muscle; empty: as in the parameter file, else the last part of the namespace'),
    ('rate_hz', '', 'ticks a second of both nodes; empty: as in the parameter file, else 100'),
    ('real_time_factor', '', 'simulated over real time, 0 as fast as possible; anything but 1 in lockstep'),
]


def nodes(context):
    value = read_arguments(__file__, ARGUMENTS, context.launch_configurations, nodes=('sim_node', 'controller_node'))
    shared = [value['params_file']] if value['params_file'] else []
    if value['rate_hz']:
        shared.append({'rate_hz': number('rate_hz', value['rate_hz'])})
    if joint := joint_of(value, 'sim_node'):
        shared.append(joint)
    simulated, controlled = list(shared), list(shared)
    if value['real_time_factor']:
        factor = number('real_time_factor', value['real_time_factor'])
        simulated.append({'real_time_factor': factor, 'lockstep_nodes': 1})
        controlled.append({'use_sim_time': factor != 1.0})
    return [
        Node(
            package='tcp_muscle_ros',
            executable=executable,
            namespace=value['namespace'],
            parameters=parameters,
            output='screen',
        )
        for executable, parameters in (('sim_node', simulated), ('controller_node', controlled))
    ]


def generate_launch_description():
    declared = [DeclareLaunchArgument(name, default_value=value, description=text) for name, value, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
