"""A finger with four muscles over a ball in MuJoCo, without a screen, and the controller of its two joints.

robot_state_publisher says where its links are (/tf), as in urdf/finger.urdf.

Needs MuJoCo: pip install mujoco. Pictures are on camera/image while somebody looks at them.

ros2 launch tcp_muscle_ros finger.launch.py
ros2 topic pub -r 10 /finger/joint_commands sensor_msgs/msg/JointState '{name: [knuckle, middle], position: [0.3, 0.5]}'
ros2 topic pub -r 10 /finger/knuckle/cocontraction_setpoint std_msgs/msg/Float64 '{data: 0.8}'
"""

from launch_ros.parameter_descriptions import ParameterValue

from tcp_muscle_ros.nodes.launching import description, installed_urdf, node, state_publisher
from tcp_muscle_ros.settings.launch_arguments import parameters_of

ARGUMENTS = [
    ('namespace', 'finger', 'namespace of the finger and its muscles, as in urdf/finger.urdf'),
    ('params_file', '', 'parameter file with muscles, joints and robot, for both nodes; empty: config/finger.yaml'),
    ('rate_hz', '', 'ticks a second of both nodes; empty: as in the parameter file, else 100'),
]
NODES = ('sim_node', 'controller_node')


def start(value):
    parameters = parameters_of(value, own='finger.yaml')
    weight = {'description_file': ParameterValue(installed_urdf('finger.urdf'), value_type=str)}
    return [
        node('sim_node', value['namespace'], parameters),
        node('controller_node', value['namespace'], [weight, *parameters]),
        state_publisher('finger.urdf', {}, value['namespace']),
    ]


def generate_launch_description():
    return description(__file__, ARGUMENTS, start, reads={'params_file': NODES})
