"""A simulated muscle.

ros2 launch tcp_muscle_ros sim.launch.py namespace:=finger_1 params_file:=muscle.yaml rate_hz:=200
"""

from tcp_muscle_ros.nodes.launching import description, node
from tcp_muscle_ros.settings.launch_arguments import number, parameters_of

ARGUMENTS = [
    ('namespace', '', 'namespace of the muscle; several muscles stand side by side in several namespaces'),
    ('params_file', '', 'parameter file under /**:, for example what tcp_muscle calibrate wrote'),
    ('joint_name', '', 'joint of the muscle; empty: as in the parameter file, else the last part of the namespace'),
    ('rate_hz', '', 'ticks a second; empty: as in the parameter file, else 100'),
    ('real_time_factor', '', 'simulated over real time, 0 as fast as possible; empty: as in the file, else 1'),
]


def start(value):
    parameters = parameters_of(value)
    if value['real_time_factor']:
        parameters.append({'real_time_factor': number('real_time_factor', value['real_time_factor'])})
    return [node('sim_node', value['namespace'], parameters)]


def generate_launch_description():
    return description(__file__, ARGUMENTS, start, reads={'params_file': ('sim_node',)})
