"""A finger with four muscles over a ball in MuJoCo, without a screen, and the controller of its two joints.

Needs MuJoCo: pip install mujoco. Pictures are on camera/image while somebody looks at them.

ros2 launch tcp_muscle_ros finger.launch.py
ros2 topic pub -r 10 /joint_commands sensor_msgs/msg/JointState '{name: [knuckle, middle], position: [0.3, 0.5]}'
ros2 topic pub -r 10 /knuckle/cocontraction_setpoint std_msgs/msg/Float64 '{data: 0.8}'
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from tcp_muscle_ros.settings.launch_arguments import number, read_arguments

ARGUMENTS = [
    ('namespace', '', 'namespace of the finger and its muscles'),
    ('params_file', '', 'parameter file with muscles, joints and robot, for both nodes; empty: config/finger.yaml'),
    ('rate_hz', '', 'ticks a second of both nodes; empty: as in the parameter file, else 100'),
]


def nodes(context):
    value = read_arguments(__file__, ARGUMENTS, context.launch_configurations, nodes=('sim_node', 'controller_node'))
    own = PathJoinSubstitution([FindPackageShare('tcp_muscle_ros'), 'config', 'finger.yaml'])
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
