"""Two simulated muscles on one joint, and the controller of its angle and co-contraction; /tf by robot_state_publisher.

ros2 launch tcp_muscle_ros antagonist.launch.py
ros2 topic pub -r 10 /antagonist/knuckle/angle_setpoint std_msgs/msg/Float64 '{data: 0.5}'
ros2 topic pub -r 10 /antagonist/knuckle/cocontraction_setpoint std_msgs/msg/Float64 '{data: 0.8}'
"""

from tcp_muscle_ros.nodes.launching import description, node, state_publisher
from tcp_muscle_ros.settings.launch_arguments import parameters_of

ARGUMENTS = [
    ('namespace', 'antagonist', 'namespace of the joint and its muscles, as in urdf/antagonist.urdf.xacro'),
    ('params_file', '', 'parameter file with muscles and joint, shared by both nodes; empty: config/antagonist.yaml'),
    ('rate_hz', '', 'ticks a second of both nodes; empty: as in the parameter file, else 100'),
]
NODES = ('sim_node', 'controller_node')


def start(value):
    parameters = parameters_of(value, own='antagonist.yaml')
    place = value['namespace']
    robot = state_publisher('antagonist.urdf.xacro', {'namespace': f'/{place.strip("/")}'}, place)
    return [*(node(name, place, parameters) for name in NODES), robot]


def generate_launch_description():
    return description(__file__, ARGUMENTS, start, reads={'params_file': NODES})
