"""What is handed on of the better muscle: its physics and the room, and how well that alone replays."""

from collections.abc import Mapping
from dataclasses import replace
from statistics import median

from tcp_muscle_ros.diagnosis.answer.findings import Diagnosis
from tcp_muscle_ros.diagnosis.answer.replaying import FAR, Own, ReplayedErrors
from tcp_muscle_ros.diagnosis.answer.sentences import headline, led_by, with_sticking
from tcp_muscle_ros.diagnosis.model.unknown import AMBIENT
from tcp_muscle_ros.diagnosis.observation.observe import conditions
from tcp_muscle_ros.muscle import ZERO_CELSIUS, Parameters
from tcp_muscle_ros.recording.mending import mend
from tcp_muscle_ros.recording.recording import Recording
from tcp_muscle_ros.settings.parameter_file import ParameterFile, Value
from tcp_muscle_ros.settings.rig import on_rig

_SAME_ROOM = 1.0  # K


def operating_with_room(diagnosis: Diagnosis, operating: Mapping[str, Value] | None = None) -> dict[str, Value]:
    """The operating parameters with the ambient temperature that all recordings share, where they do."""
    found = [v.value for name, v in diagnosis.sensors.items() if name.startswith(f'{AMBIENT} [')]
    same = bool(found) and max(found) - min(found) < _SAME_ROOM
    room: dict[str, Value] = {'ambient_temperature_c': median(found) - ZERO_CELSIUS} if same else {}
    return {**(operating or {}), **room}


def physics_only(parameters: Parameters) -> Parameters:
    """The same muscle without effects of sensors, which belong to a rig and not to a muscle."""
    kept = [name for name in parameters.effects if parameters.stage(name) != 'sensor']
    return parameters.only_effects(kept)


def with_replay(diagnosis: Diagnosis, recordings: list[Recording], operating: Mapping[str, Value]) -> Diagnosis:
    """The diagnosis with the errors that ``tcp_muscle replay`` shows on the same bags, with the nominal parameters,
    recalibrated, and with improved.yaml on rig.yaml; its headline speaks of these. What was left out or cut is not in
    them.

    Empties ``recordings``: a long one is let go before it is replayed.
    """
    if not diagnosis.fit:
        return diagnosis
    d, room = diagnosis, operating_with_room(diagnosis, operating)
    improved = on_rig(physics_only(d.improved), d.rig)
    muscles = [(d.nominal, dict(operating)), (d.calibrated or d.nominal, room), (improved, room)]
    errors = [ReplayedErrors() for _ in muscles]
    strayed: list[Own] = []  # rooms of the nominal muscle
    ages = iter(d.ages)  # one for each part, in the order in which they were diagnosed; none for what does not age
    while recordings:
        for part in mend(recordings.pop(0)).parts:  # what no model follows counts against none
            age = next(ages, None)
            for error, (muscle, given) in zip(errors, muscles, strict=True):
                then = muscle.replace(age.values) if age else muscle
                own = error.add_as_read(part, muscle, conditions(ParameterFile(muscle, given)), then)
                if muscle is d.nominal and abs(own.strayed) > FAR:
                    strayed.append(own)
    before, recalibrated, after = (error.rmse() for error in errors)
    fit = {
        name: replace(f, nominal=before[name], calibrated=recalibrated[name], improved=after[name])
        for name, f in d.fit.items()
        if name in after
    }
    opening = headline(d.verdict, d.findings, d.location, fit, d.unexplained, d.headline, d.tried)
    said = led_by(d.stopped, with_sticking(opening, d.sticking))
    farthest = max(strayed, key=lambda own: abs(own.strayed), default=None)
    beside = (f'the nominal errors: {farthest.warning}',) if farthest else ()
    return replace(d, fit=fit, headline=said, notes=(*d.notes, *beside))
