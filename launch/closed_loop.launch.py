"""A simulated muscle and its position controller, from one parameter file.

ros2 launch tcp_muscle_ros closed_loop.launch.py
ros2 topic pub -r 10 /displacement_setpoint std_msgs/msg/Float64 '{data: 0.02}'
"""

from tcp_muscle_ros.nodes.launching import description, node
from tcp_muscle_ros.settings.launch_arguments import number, parameters_of

ARGUMENTS = [
    ('namespace', '', 'namespace of the muscle and of its controller'),
    ('params_file', '', 'parameter file under /**:, shared by both nodes'),
    ('joint_name', '', 'joint of the muscle; empty: as in the parameter file, else the last part of the namespace'),
    ('rate_hz', '', 'ticks a second of both nodes; empty: as in the parameter file, else 100'),
    ('real_time_factor', '', 'simulated over real time, 0 as fast as possible; anything but 1 in lockstep'),
]


def start(value):
    shared = parameters_of(value)
    simulated, controlled = list(shared), list(shared)
    if value['real_time_factor']:
        factor = number('real_time_factor', value['real_time_factor'])
        simulated.append({'real_time_factor': factor, 'lockstep_nodes': 1})
        controlled.append({'use_sim_time': factor != 1.0})
    return [
        node('sim_node', value['namespace'], simulated),
        node('controller_node', value['namespace'], controlled),
    ]


def generate_launch_description():
    return description(__file__, ARGUMENTS, start, reads={'params_file': ('sim_node', 'controller_node')})
