"""The controllers that a node's parameters describe: of the muscle's own model, or of the one in ``model_file``."""

from tcp_muscle_ros.control.handover import Handover
from tcp_muscle_ros.control.tracking import TrackingController
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.nodes.parameters import Settings
from tcp_muscle_ros.settings.parameter_file import read

_models: dict[str, Parameters] = {}  # of model_file, as they were when they were checked


def check_model(settings: Settings) -> str:
    """Read ``model_file`` where one is named. Why it is taken as it was read before, '' where it is as it stands there.

    Raises:
        BadInput: it cannot be read, and never was.
    """
    path = settings['model_file']
    try:
        if path:
            _models[path] = read(path).parameters
    except BadInput as error:
        if path not in _models:  # one that was read stays in force: a limit can be lowered without its file
            raise
        return f'the model is as it was read before: {error}'
    return ''


def other_model(settings: Settings) -> Parameters | None:
    """The muscle of ``model_file`` as it was checked, None where none is named. What else stands there counts nothing.

    A tick may ask: the file is not read again.
    """
    return _models[settings['model_file']] if settings['model_file'] else None


def make_controller(settings: Settings, model: Parameters | None = None) -> TrackingController:
    """The controller that the parameters describe, of their own muscle or of another model of it.

    Raises:
        BadInput: values that make no muscle or no controller.
    """
    return TrackingController(
        model or settings.muscle(),
        1.0 / settings['rate_hz'],
        settings['current_limit_a'],
        settings['load_n'],
        settings.kelvin('ambient_temperature_c'),
        mode=settings['mode'],
        temperature_limit=settings.kelvin('derate_temperature_c'),
        time_constant=settings['time_constant_s'],
        probe_current=settings['probe_current_a'] if settings['feedback'] == 'resistance' else 0.0,
        pid_kp=settings['pid_kp_a_per_m'],
        pid_ki=settings['pid_ki_a_per_m_s'],
        pid_kd=settings['pid_kd_a_s_per_m'],
        pid_filter_time=settings['pid_filter_time_s'],
    )


def make_handover(settings: Settings) -> Handover:
    """The same, ready to take another model; with that of ``model_file`` in charge where one is named. BadInput."""
    made, model = Handover(make_controller(settings), 1.0 / settings['rate_hz']), other_model(settings)
    if model is not None:
        made.begin(make_controller(settings, model))
    return made
