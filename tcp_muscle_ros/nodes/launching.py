"""What all launch files do: declare arguments, read them, and start nodes of this package.

Only launch files import it: launch comes with a ROS 2 installation.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import Command, FindExecutable, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from tcp_muscle_ros.settings.launch_arguments import Row, read_arguments


def description(
    launch_file: str,
    rows: Sequence[Row],
    start: Callable[[dict[str, str]], list[Any]],
    reads: Mapping[str, Sequence[str]] | None = None,
) -> LaunchDescription:
    """What a launch file describes.

    Args:
        launch_file: its own path.
        rows: the arguments that it declares.
        start: of their values, by name, what it starts.
        reads: of each argument that is a parameter file, the names of the nodes that read it.
    """

    def started(context: Any) -> list[Any]:
        return start(read_arguments(launch_file, rows, context.launch_configurations, reads=reads))

    declared = [DeclareLaunchArgument(name, default_value=value, description=text) for name, value, text in rows]
    return LaunchDescription([*declared, OpaqueFunction(function=started)])


def node(executable: str, namespace: str, parameters: Sequence[Any]) -> Node:
    """A node of this package. Of the parameters, files and dictionaries, later ones win."""
    return Node(
        package='tcp_muscle_ros',
        executable=executable,
        namespace=namespace,
        parameters=list(parameters),
        output='screen',
    )


def installed_urdf(name: str) -> PathJoinSubstitution:
    """The path of a file of urdf/ where the package is installed."""
    return PathJoinSubstitution([FindPackageShare('tcp_muscle_ros'), 'urdf', name])


def state_publisher(urdf: str, arguments: Mapping[str, str], namespace: str = '') -> Node:
    """robot_state_publisher of a file of urdf/, given its arguments: makes /tf of the joint_states of the namespace."""
    words = [f' {name}:={value}' for name, value in arguments.items()]
    robot = Command([FindExecutable(name='xacro'), ' ', installed_urdf(urdf), *words])
    return Node(
        package='robot_state_publisher',
        executable='robot_state_publisher',
        namespace=namespace,
        parameters=[{'robot_description': ParameterValue(robot, value_type=str)}],
    )
