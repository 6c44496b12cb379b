"""A simulated muscle under ros2_control: a joint with a position command and a state, and a controller for it.

The muscle's own topics stand in its namespace, so its joint_states are not those of joint_state_broadcaster.

ros2 launch tcp_muscle_ros ros2_control.launch.py
ros2 topic pub --once /muscle_position_controller/commands std_msgs/msg/Float64MultiArray '{data: [0.02]}'
"""

import os
from pathlib import Path
from urllib.parse import quote

from launch_ros.actions import Node

from tcp_muscle_ros.files.outputs import in_place_of
from tcp_muscle_ros.nodes.launching import description, node, state_publisher
from tcp_muscle_ros.settings.launch_arguments import config_file, joint_of, parameters_of

ARGUMENTS = [
    ('namespace', '', 'namespace of the muscle; empty: its joint_name'),
    ('joint_name', '', 'joint of the muscle; empty: as in the parameter file, else the last part of the namespace'),
    ('params_file', '', 'parameter file of the muscle under /**:, shared by both nodes'),
    ('controllers_file', '', 'parameters of the controllers; empty: config/controllers.yaml with the joint_name'),
]
MUSCLE = ('sim_node', 'controller_node')
CONTROLLERS = ['joint_state_broadcaster', 'muscle_position_controller']


def controllers_for(joint):
    """config/controllers.yaml for a joint of another name: a copy in ROS's own folder, the same at each start."""
    text = config_file('controllers.yaml').read_text(encoding='utf-8')
    home = Path(os.environ.get('ROS_HOME') or Path.home() / '.ros')
    copy = home / 'tcp_muscle_ros' / f'controllers_{quote(joint, safe="")}.yaml'
    with in_place_of(copy) as draft:
        draft.write_text(text.replace('tcp_muscle', joint), encoding='utf-8')
    return str(copy)


def start(value):
    joint = joint_of(value, MUSCLE[0])
    namespace = value['namespace'].strip('/') or joint
    controllers = value['controllers_file'] or controllers_for(joint)
    return [
        *(node(name, namespace, parameters_of(value)) for name in MUSCLE),
        state_publisher('tcp_muscle.urdf.xacro', {'name': joint, 'namespace': f'/{namespace}'}),
        Node(package='controller_manager', executable='ros2_control_node', parameters=[controllers], output='screen'),
        Node(package='controller_manager', executable='spawner', arguments=[*CONTROLLERS, '--param-file', controllers]),
    ]


def generate_launch_description():
    return description(
        __file__, ARGUMENTS, start, reads={'params_file': MUSCLE, 'controllers_file': ('controller_manager',)}
    )
