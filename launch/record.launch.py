"""Record one muscle's topics to a bag until interrupted.

ros2 launch tcp_muscle_ros record.launch.py output:=my_run namespace:=finger_1
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch_ros.substitutions import ExecutableInPackage

from tcp_muscle_ros.settings.launch_arguments import read_arguments

ARGUMENTS = [
    ('output', 'recording', 'folder of the bag; must not exist yet'),
    ('namespace', '', 'namespace of the muscle'),
    ('duration_s', '', 'seconds to record; empty: until interrupted'),
]


def processes(context):
    value = read_arguments(__file__, ARGUMENTS, context.launch_configurations)
    options = ['--output', value['output']]
    if value['namespace']:
        options += ['--namespace', value['namespace']]
    if value['duration_s']:
        options += ['--duration', value['duration_s']]
    # A plain process: the tool is a command line, not a node that takes --ros-args.
    tool = ExecutableInPackage(executable='tcp_muscle', package='tcp_muscle_ros')
    return [ExecuteProcess(cmd=[tool, 'record', *options], output='screen')]


def generate_launch_description():
    declared = [DeclareLaunchArgument(name, default_value=value, description=text) for name, value, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=processes)])
