"""A simulated muscle that conceals an effect, its controller, and a twin that knows nothing of it.

ros2 launch tcp_muscle_ros twin.launch.py
ros2 topic pub -r 10 /displacement_setpoint std_msgs/msg/Float64 '{data: 0.01}'
ros2 topic echo /diagnostics
"""

from tcp_muscle_ros.nodes.launching import description, node
from tcp_muscle_ros.settings.launch_arguments import switch

ARGUMENTS = [
    ('namespace', '', 'namespace of the muscle, its controller and its twin'),
    ('params_file', '', 'parameter file of the simulated muscle; empty: the paper with the concealed effect'),
    ('concealed', 'natural_convection', 'the effect that the simulated muscle has and the twin does not know'),
    ('model_file', '', 'parameter file of the muscle that twin and controller assume; empty: that of the paper'),
    ('rig_file', '', 'rig.yaml: what the instruments do'),
    ('auto_diagnose', 'false', 'whether an alarm starts a diagnosis'),
    ('auto_adopt', 'false', 'with auto_diagnose: a model that predicts better is adopted, by the controller too'),
]
READS = {'params_file': ('sim_node',), 'model_file': ('controller_node', 'twin_node')}


def start(value):
    muscle = value['params_file'] or {'effects': [value['concealed']]}
    model = [value['model_file']] if value['model_file'] else []
    twin = {
        'params_file': value['model_file'],
        'rig_file': value['rig_file'],
        'auto_diagnose': switch('auto_diagnose', value['auto_diagnose']),
        'auto_adopt': switch('auto_adopt', value['auto_adopt']),
        'adopting_controller': 'controller_node',
    }
    return [
        node('sim_node', value['namespace'], [muscle]),
        node('controller_node', value['namespace'], model),
        node('twin_node', value['namespace'], [twin]),
    ]


def generate_launch_description():
    return description(__file__, ARGUMENTS, start, reads=READS)
