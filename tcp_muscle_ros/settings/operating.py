"""The nodes' operating parameters: how a muscle is run, not what it is. Each is written here, once.

The ROS declarations, the check of parameter files and the documents are made from this table. Units stand in the
names. ``owners`` says which node reads it; a file under ``/**:`` may serve both.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.muscle.edges import read_numbers
from tcp_muscle_ros.muscle.parameter import GRAVITY

Default = float | int | bool | str | tuple[float, ...]

DEFAULT_SET = 'karami_tadesse_2017'  # the muscle, where none is named
SIM, CONTROL, DRIVER = 'sim_node', 'controller_node', 'serial_driver_node'
BOTH = (SIM, CONTROL)
ALL = (SIM, CONTROL, DRIVER)
_HUGE = 1e9


@dataclass(frozen=True)
class Operating:
    """One operating parameter. ``low`` and ``high`` bound numbers; ``choices`` lists the words it may be.

    A default of several numbers makes it an array of ``fewest`` to ``most`` of them.
    ``same_as``: where it is not given, the value of that parameter. ``per_node``: one value for all muscles of a node.
    """

    name: str
    default: Default
    unit: str
    meaning: str
    owners: tuple[str, ...]
    low: float = 0.0
    high: float = _HUGE
    choices: tuple[str, ...] = ()
    read_only: bool = False
    same_as: str = ''
    per_node: bool = False
    fewest: int = 0
    most: int = 0

    @property
    def number(self) -> float:
        """The default of one that is a number."""
        assert isinstance(self.default, int | float)
        return float(self.default)


_ROWS = (
    Operating('rate_hz', 100.0, 'Hz', 'ticks a second', ALL, 1.0, 2000.0, read_only=True, per_node=True),
    Operating(
        'joint_name',
        'tcp_muscle',
        '',
        'joint, also in the frame of stamped messages (<joint_name>_moving_end); default in a namespace: its last part',
        ALL,
        read_only=True,
    ),
    Operating('start_enabled', True, '', 'whether current may flow from the start', ALL, read_only=True),
    Operating(
        'load_n',
        0.06 * GRAVITY,
        'N',
        'pulling force until one arrives; displacement is zero at rest at T0 under it',
        BOTH,
        0.0,
        1000.0,
        read_only=True,
    ),
    Operating('ambient_temperature_c', 23.0, 'degC', 'ambient until one arrives', BOTH, -40.0, 100.0),
    Operating(
        'current_limit_a', 0.27, 'A', 'largest current; 0.27 A is the range that the paper tested', ALL, 0.0, 100.0
    ),
    Operating('slew_limit_a_per_s', 0.0, 'A/s', 'largest change of the current; 0 = no limit', ALL),
    Operating('derate_temperature_c', 100.0, 'degC', 'above it the current limit falls linearly', ALL, -40.0, 250.0),
    Operating(
        'max_temperature_c', 115.0, 'degC', 'at it the current is off until the fault is cleared', ALL, -40.0, 250.0
    ),
    Operating(
        'command_timeout_s', 0.5, 's', 'older commands count as 0 A; 0 = never (sim)', (SIM, DRIVER), 0.0, 3600.0
    ),
    Operating(
        'real_time_factor',
        1.0,
        '1',
        'simulated seconds a second; 0 = as fast as possible',
        (SIM,),
        0.0,
        1000.0,
        read_only=True,
        per_node=True,
    ),
    Operating(
        'lockstep_nodes',
        0,
        '',
        'real_time_factor other than 1: nodes with use_sim_time that must be there before the first tick',
        (SIM,),
        0,
        100,
        read_only=True,
        per_node=True,
    ),
    Operating(
        'lockstep_timeout_s',
        10.0,
        's',
        'real_time_factor other than 1: a node that takes longer for a tick is no longer waited for',
        (SIM,),
        0.1,
        3600.0,
        read_only=True,
        per_node=True,
    ),
    Operating(
        'robot',
        '',
        '',
        'robot in MuJoCo whose tendons the muscles are: arm, finger or an MJCF file; empty: none',
        (SIM,),
        read_only=True,
        per_node=True,
    ),
    Operating(
        'image_rate_hz',
        0.0,
        'Hz',
        'pictures of the robot a second, while somebody looks at camera/image; 0 = none',
        (SIM,),
        0.0,
        60.0,
        read_only=True,
        per_node=True,
    ),
    Operating('image_width', 320, '', 'pixels', (SIM,), 16, 1920, read_only=True, per_node=True),
    Operating('image_height', 200, '', 'pixels', (SIM,), 16, 1080, read_only=True, per_node=True),
    Operating('rig_file', '', '', 'rig.yaml: what the instruments do', (SIM,), read_only=True),
    Operating(
        'initial_temperature_c',
        23.0,
        'degC',
        'fibre at the start; default: the ambient',
        (SIM,),
        -40.0,
        200.0,
        read_only=True,
        same_as='ambient_temperature_c',
    ),
    Operating(
        'end',
        'load',
        '',
        'what holds the end of the muscle',
        (SIM,),
        choices=('load', 'blocked', 'spring'),
        read_only=True,
    ),
    Operating(
        'held_length_m',
        0.0,
        'm',
        'blocked: length; spring: distance to its far end; 0 = tension load_n at rest',
        (SIM,),
        0.0,
        100.0,
        read_only=True,
    ),
    Operating('spring_rate_n_per_m', 0.0, 'N/m', 'rate of the spring at the end', (SIM,), 0.0, read_only=True),
    Operating(
        'spring_rest_length_m', 0.0, 'm', 'length of the spring without force', (SIM,), 0.0, 100.0, read_only=True
    ),
    Operating('min_sense_current_a', 0.0, 'A', 'below it no resistance is published', (SIM, DRIVER), 0.0, 100.0),
    Operating('seed', 0, '', 'of the sensor noise', (SIM,), read_only=True),
    *(
        # The controller asks the steps of its feedback whether a value that does not change is a frozen one.
        Operating(
            f'{channel}_{kind}_{unit.lower()}',
            0.0,
            unit,
            f'{meaning} of the {channel} sensor',
            BOTH if kind == 'quantum' and channel in ('resistance', 'displacement') else (SIM,),
        )
        for channel, unit in (('temperature', 'K'), ('resistance', 'ohm'), ('displacement', 'm'), ('force', 'N'))
        for kind, meaning in (('noise', 'standard deviation'), ('quantum', 'step'))
    ),
    *(
        Operating(f'{channel}_lag_s', 0.0, 's', f'first-order lag of the {channel} sensor', (SIM,), 0.0, 100.0)
        for channel in ('temperature', 'resistance', 'displacement', 'force')
    ),
    Operating('port', '/dev/ttyACM0', '', 'serial port of the board', (DRIVER,), read_only=True),
    Operating('baud_rate', 115200, '', 'of the serial port', (DRIVER,), 1200, 4_000_000, read_only=True),
    Operating(
        'reply_timeout_s',
        0.2,
        's',
        'a command that the board has not answered so long stops the current',
        (DRIVER,),
        0.02,
        10.0,
    ),
    Operating('mode', 'model', '', 'model inverse with feedback, or plain PID', (CONTROL,), choices=('model', 'pid')),
    Operating(
        'feedback',
        'displacement',
        '',
        'what closes the loop',
        (CONTROL,),
        choices=('displacement', 'resistance'),
        read_only=True,
    ),
    Operating(
        'feedback_timeout_s',
        0.0,
        's',
        'older feedback counts as lost; 0 = the longer of 3 periods and 0.2 s',
        (CONTROL,),
        0.0,
        60.0,
    ),
    Operating(
        'probe_current_a',
        0.0,
        'A',
        'feedback resistance: flows while no resistance comes, so that one can be measured; 0 = none',
        (CONTROL,),
        0.0,
        1.0,
    ),
    Operating(
        'model_file',
        '',
        '',
        'parameter file of the muscle that the controller assumes, such as improved.yaml; empty: the parameters',
        (CONTROL,),
    ),
    Operating(
        'description_file',
        '',
        '',
        'URDF of the robot whose joints are controlled: its weight is held before it is felt; empty: none',
        (CONTROL,),
        read_only=True,
        per_node=True,
    ),
    Operating('time_constant_s', 0.07, 's', 'mode model: of the closed loop', (CONTROL,), 1e-3, 100.0),
    Operating('pid_kp_a_per_m', 200.0, 'A/m', 'mode pid: proportional gain', (CONTROL,)),
    Operating('pid_ki_a_per_m_s', 32.0, 'A/(m s)', 'mode pid: integral gain', (CONTROL,)),
    Operating('pid_kd_a_s_per_m', 20.0, 'A s/m', 'mode pid: derivative gain', (CONTROL,)),
    Operating('pid_filter_time_s', 0.05, 's', 'mode pid: filter of the derivative', (CONTROL,), 0.0, 100.0),
)
OPERATING: Mapping[str, Operating] = {row.name: row for row in _ROWS}

# The lists that make one node work for several muscles, and for joints between two of them.
MUSCLES, JOINTS = 'muscles', 'joints'
_JOINT_ROWS = (
    Operating('agonist', '', '', 'the muscle that turns the joint towards positive angles', BOTH, read_only=True),
    Operating('antagonist', '', '', 'the muscle that turns it back', BOTH, read_only=True),
    Operating('radius_m', 0.01, 'm', 'of the pulley on which both pull', BOTH, 1e-5, 1.0, read_only=True),
    Operating('inertia_kg_m2', 1e-5, 'kg m2', 'of what turns', (SIM,), 1e-9, 100.0, read_only=True),
    Operating('damping_n_m_s', 4e-4, 'N m s', 'of the joint, viscous', (SIM,), 0.0, 1000.0, read_only=True),
    Operating('torque_n_m', 0.0, 'N m', 'from outside until one arrives', (SIM,), -1000.0, 1000.0, read_only=True),
    Operating('low_rad', -1.2, 'rad', 'stop at negative angles', BOTH, -10.0, 0.0, read_only=True),
    Operating('high_rad', 1.2, 'rad', 'stop at positive angles', BOTH, 0.0, 10.0, read_only=True),
    Operating('cocontraction_n', 0.5, 'N', 'mean tension of both muscles until one arrives', (CONTROL,), 0.0, 1000.0),
    Operating('torque_filter_s', 0.3, 's', 'of the torque that the tensions show', (CONTROL,), 0.0, 100.0),
)
JOINT: Mapping[str, Operating] = {row.name: row for row in _JOINT_ROWS}

TWIN_NODE = 'twin_node'
_TWIN_ROWS = (
    Operating('rate_hz', 100.0, 'Hz', 'at least that of the muscle', (TWIN_NODE,), 1.0, 2000.0, read_only=True),
    Operating(
        'params_file',
        '',
        '',
        'parameter file of the muscle that the twin assumes; empty: that of the paper',
        (TWIN_NODE,),
        read_only=True,
    ),
    Operating('rig_file', '', '', "rig.yaml: what the rig's instruments do", (TWIN_NODE,), read_only=True),
    Operating('auto_diagnose', False, '', 'whether an alarm starts a diagnosis, at low priority', (TWIN_NODE,)),
    Operating('auto_adopt', False, '', 'with auto_diagnose: a model that predicts better is adopted', (TWIN_NODE,)),
    Operating('report_folder', 'twin_reports', '', 'where alarms leave bags and reports', (TWIN_NODE,), read_only=True),
    Operating('keep_s', 600.0, 's', 'how much is kept in memory', (TWIN_NODE,), 10.0, 3600.0, read_only=True),
    Operating(
        'collect_s',
        120.0,
        's',
        'how much of what differs is recorded before it is diagnosed',
        (TWIN_NODE,),
        1.0,
        3600.0,
    ),
    Operating('trial_s', 60.0, 's', 'how much of warm muscle two models are compared on', (TWIN_NODE,), 1.0, 3600.0),
    Operating(
        'adopting_controller',
        '',
        '',
        'auto_adopt: controller_node that adopts the model too; empty: none',
        (TWIN_NODE,),
        read_only=True,
    ),
)
TWIN: Mapping[str, Operating] = {row.name: row for row in _TWIN_ROWS}


def joint_in(namespace: str) -> str:
    """The joint of the muscle in a namespace, where no ``joint_name`` is given."""
    return namespace.strip('/').rpartition('/')[2] or str(OPERATING['joint_name'].default)


def read_value(row: Operating, value: object) -> Default:
    """A value from a file, the command line or a request as the parameter's own type; a whole number may be a float.

    Raises:
        BadInput: a wrong type, outside the bounds, or none of the choices.
    """
    if isinstance(row.default, tuple):
        return read_numbers(row.name, value, row.low, row.high, row.fewest, row.most, row.unit)
    kind = type(row.default)
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if kind is int and isinstance(value, float) and value.is_integer():
        value = int(value)
    if type(value) is not kind:
        number = 'a number, ' if kind is float else ''
        raise BadInput(f"parameter '{row.name}' is {shown(value)}; expected {number}{_expected(row)}")
    if isinstance(value, str):
        if row.choices and value not in row.choices:
            raise BadInput(f"parameter '{row.name}' is '{value}'{nearest(value, row.choices)}")
        return value
    if isinstance(value, bool):
        return value
    assert isinstance(value, int | float)
    if not row.low <= value <= row.high:  # False for NaN
        raise BadInput(f"parameter '{row.name}' is {shown(value)}; expected {_expected(row)}")
    return value


def _expected(row: Operating) -> str:
    if isinstance(row.default, bool):
        return 'true or false'
    if isinstance(row.default, str):
        return ' or '.join(row.choices) or 'a text'
    whole = 'a whole number, ' if isinstance(row.default, int) else ''
    unit = '' if row.unit in ('', '1') else f' {row.unit}'
    return f'{whole}{row.low:g} to {row.high:g}{unit} ({row.meaning})'


def shown(value: object) -> str:
    """A value as an error shows it."""
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if value is None:
        return 'empty'
    return f'{value:g}' if isinstance(value, float) else f"'{value}'" if isinstance(value, str) else str(value)
