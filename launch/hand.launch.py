"""A hand of sixteen simulated muscles in one process, and their controllers in another.

ros2 launch tcp_muscle_ros hand.launch.py
ros2 topic pub -r 10 /thumb_flexor/displacement_setpoint std_msgs/msg/Float64 '{data: 0.02}'
"""

from tcp_muscle_ros.nodes.launching import description, node
from tcp_muscle_ros.settings.launch_arguments import parameters_of, switch

ARGUMENTS = [
    ('namespace', '', 'namespace of the hand: left/thumb_flexor/temperature'),
    ('params_file', '', 'parameter file with the list of muscles, shared by both nodes; empty: config/hand.yaml'),
    ('rate_hz', '', 'ticks a second of both nodes; empty: as in the parameter file'),
    ('controller', 'true', 'false: the muscles alone, driven through current_command'),
]
NODES = ('sim_node', 'controller_node')


def start(value):
    parameters = parameters_of(value, own='hand.yaml')
    names = NODES if switch('controller', value['controller']) else NODES[:1]
    return [node(name, value['namespace'], parameters) for name in names]


def generate_launch_description():
    return description(__file__, ARGUMENTS, start, reads={'params_file': NODES})
