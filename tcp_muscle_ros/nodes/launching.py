"""What all launch files do: declare arguments, read them, and start nodes of this package.

Only launch files import it: launch comes with a ROS 2 installation.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch_ros.actions import Node

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
