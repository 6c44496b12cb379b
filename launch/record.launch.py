"""Record one muscle's topics to a bag until interrupted.

ros2 launch tcp_muscle_ros record.launch.py output:=my_run namespace:=finger_1
"""

from launch.actions import ExecuteProcess
from launch_ros.substitutions import ExecutableInPackage

from tcp_muscle_ros.nodes.launching import description

ARGUMENTS = [
    ('output', 'recording', 'folder of the bag; must not exist yet'),
    ('namespace', '', 'namespace of the muscle'),
    ('duration_s', '', 'seconds to record; empty: until interrupted'),
]


def start(value):
    options = ['--output', value['output']]
    if value['namespace']:
        options += ['--namespace', value['namespace']]
    if value['duration_s']:
        options += ['--duration', value['duration_s']]
    # A plain process: the tool is a command line, not a node that takes --ros-args.
    tool = ExecutableInPackage(executable='tcp_muscle', package='tcp_muscle_ros')
    return [ExecuteProcess(cmd=[tool, 'record', *options], output='screen')]


def generate_launch_description():
    return description(__file__, ARGUMENTS, start)
