"""Whether a recording can be that of a muscle like the one assumed: the gate of every command that fits or replays.

``recording/plausibility.py`` looks at a recording alone. Here it meets the muscle: a load in gram draws it to a hundred
times its length, a current in the wrong unit heats it by a millionth of what was seen. A fit would bend the muscle
until it agrees. What is refused is refused in one line that says how to mend it; a muscle that is merely another than
assumed passes.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.scatter import white_sigma
from tcp_muscle_ros.errors import BadInput, Option
from tcp_muscle_ros.muscle import Outputs, Parameters
from tcp_muscle_ros.muscle.arrays import Array
from tcp_muscle_ros.recording import options
from tcp_muscle_ros.recording.plausibility import refuse_implausible
from tcp_muscle_ros.recording.recording import CHANNELS, Recording
from tcp_muscle_ros.recording.units import UNITS, unit_of

_STRETCH = 5.0  # times its length, which no load draws a coil to and leaves it one
_OTHER_MUSCLE = 100.0  # times: so far, but no farther, is another muscle from the one assumed
_WHOLE = 150.0  # K above the room: nylon, which melts at some 220 to 260 degC, softens as the law says no farther
_ALIKE = 0.9  # correlation from which on a channel is the model's but for a factor
_TWINKLES = 6.0  # standard deviations of a mean of samples, within which nothing moves
_FIRST = 0.2  # of what a factor says, and five times that: another unit explains it
_PARTS = 20  # of a recording, whose means are compared
_STATE = ('; or state that of this muscle in ', options.PARAMS)


def admit(recording: Recording, muscle: Parameters, *, ambient: float | None, load: float | None) -> None:
    """BadInput where a recording is not what it says it is, or no muscle like this one could have given it.

    Args:
        recording: as read, before anything is mended.
        muscle: as assumed.
        ambient: K, and ``load`` N: what the user states of the run where the recording does not.
    """
    refuse_implausible(recording, ambient)
    _refuse_pull(recording, muscle, load)
    _refuse_resistance(recording, muscle)


def _refuse_pull(recording: Recording, muscle: Parameters, load: float | None) -> None:
    """A load or force under which the muscle would be many times as long as it is."""
    pulls = {
        name: float(np.percentile(np.abs(recording[name].value), 95.0))
        for name in ('load', 'force')
        if len(recording.channels.get(name, ()))
    }
    if 'load' not in pulls and load is not None:
        pulls['load_n'] = load
    for name, force in pulls.items():
        stretch = force / muscle['k0'] / muscle['H0']
        if stretch > _STRETCH:
            stated = name == 'load_n'
            taken = 'N' if stated else recording.unit(name)
            shown = unit_of(taken.lstrip('-'), 'force', recording.path).from_si(force)
            grams = '-g' if taken.startswith('-') else 'g'
            raw = f'state it in N, not g ({force:g} g are {UNITS["g"].to_si(force):.3g} N)'
            raise BadInput(
                f'{recording.path}: {name} is about {shown:.4g} {taken}, which would draw this muscle (k0 = '
                f'{muscle["k0"]:.4g} N/m) to {stretch:.0f} times its length: ',
                *([raw] if stated else _if_in('g', options.this_unit(name, grams))),
                *_STATE,
                ' (k0)',
            )


def _refuse_resistance(recording: Recording, muscle: Parameters) -> None:
    """A resistance that is far from any muscle's like this."""
    if 'resistance' not in recording or not len(recording['resistance']):
        return
    typical, taken = float(np.median(recording['resistance'].value)), recording.unit('resistance')
    factor = typical / muscle['R0']
    if 1.0 / _OTHER_MUSCLE < factor < _OTHER_MUSCLE:
        return
    raw = unit_of(taken, 'resistance', recording.path).from_si(typical)
    fitting = [u.name for u in UNITS.values() if u.quantity == 'resistance' and 0.1 < u.to_si(raw) / muscle['R0'] < 10]
    raise BadInput(
        f'{recording.path}: resistance is about {raw:.4g} {taken}, this muscle has {muscle["R0"]:.4g} ohm: ',
        *(_if_in(fitting[0], options.this_unit('resistance', fitting[0])) if fitting else ['check its unit']),
        *_STATE,
        ' (R0)',
    )


def refuse_other_scale(experiment: Experiment, muscle: Parameters, recording: Recording) -> None:
    """BadInput where a channel follows the model but for a factor that no other muscle explains: a unit is wrong.

    Also where the model's answer is not finite. ``recording``: what the experiment was made of. Where this muscle would
    melt under a drive that another one bears, it is compared under less.
    """
    borne, outputs, heat = _borne(experiment, muscle)
    predicted = _finite(borne, outputs)
    factors = {}
    for name, observed in experiment.observed.items():
        shown = predicted[name]
        spread, seen = float(np.std(shown)), float(np.std(observed.value))
        if name == 'resistance' or observed.value.size < 20 or spread == 0.0 or seen == 0.0:
            continue
        with np.errstate(all='ignore'):  # of what hardly moves at all the squares may vanish
            alike = float(np.corrcoef(shown, observed.value)[0, 1])
        if alike > _ALIKE:
            factors[name] = seen / spread * (heat if name == 'temperature' else 1.0)
    for name, factor in factors.items():
        if 1.0 / _OTHER_MUSCLE < factor < _OTHER_MUSCLE:
            continue
        kind = experiment.imposed.kind
        more = f'{factor:.1e} times as much' if factor > 1.0 else f'{1.0 / factor:.1e} times less'
        raise BadInput(
            f'{experiment.name}: {name} moves as this muscle would under this {kind}, but {more}: ',
            *_other_unit(recording, kind, name, factor),
            *_STATE,
        )


def _borne(experiment: Experiment, muscle: Parameters) -> tuple[Experiment, Outputs, float]:
    """The experiment with so much of its heat that this muscle stays whole, what the model shows then, and which share
    that is; as it is where no other muscle would bear it either."""
    imposed, heat, borne = experiment.imposed, 1.0, experiment
    outputs = whole = _outputs(borne, muscle)
    while heat > 1.0 / _OTHER_MUSCLE:
        warm = outputs.fibre_temperature
        if np.all(np.isfinite(warm)) and float(np.max(warm - imposed.ambient)) < _WHOLE:
            return borne, outputs, heat
        heat *= 0.5
        borne = replace(experiment, imposed=replace(imposed, drive=_drive(imposed.kind, heat) * imposed.drive))
        outputs = _outputs(borne, muscle)
    return experiment, whole, 1.0


def _outputs(experiment: Experiment, muscle: Parameters) -> Outputs:
    """What the model shows, perhaps not finite."""
    with np.errstate(all='ignore'):
        return experiment.outputs(muscle, only=('fibre_temperature', *experiment.observed))


def _drive(kind: str, heat: float) -> float:
    """How many times the drive gives so many times the heat."""
    return heat if kind == 'power' else float(np.sqrt(heat))


def _if_in(unit: str, option: Option, what: str = 'it') -> list[str | Option]:
    """What to say if something is recorded in a unit."""
    return [f'if {what} is recorded in {unit}, say ', option]


def _other_unit(recording: Recording, kind: str, name: str, factor: float) -> list[str | Option]:
    """Which units of the input or of a channel would explain that the channel moves so many times as much."""
    found = [
        _if_in(unit, options.this_unit(each, unit), each)
        for each, ratio in ((kind, _drive(kind, factor)), (name, 1.0 / factor))
        if each in recording
        for unit in _larger(recording.unit(each), each, ratio)
    ]
    if not found:
        return [f'check the units of {kind} and {name} (', options.this_unit('NAME', 'UNIT'), ')']
    return [part for mend in found for part in (', or ', *mend)][1:]


def _larger(taken: str, name: str, ratio: float) -> list[str]:
    """The units that are about so many times the one a channel was taken to be in."""
    quantity = UNITS[CHANNELS[name].unit].quantity
    sign, scale = '-' if taken.startswith('-') else '', abs(unit_of(taken, quantity, name).scale)
    fitting = [u for u in UNITS.values() if u.quantity == quantity and _FIRST < u.scale / scale / ratio < 1.0 / _FIRST]
    return [sign + unit.name for unit in fitting if sign + unit.name != taken]


def _finite(experiment: Experiment, outputs: Outputs) -> dict[str, Array]:
    """What the model shows at the instants observed (SI, by channel). BadInput where it is not finite."""
    hot = outputs.fibre_temperature
    wild = ~np.isfinite(hot)
    for name in experiment.observed:
        wild |= ~np.isfinite(getattr(outputs, name))
    if wild.any():
        at = int(np.argmax(wild))
        imposed = experiment.imposed
        raise BadInput(
            f'{experiment.name}: the model has no finite answer from {imposed.time[at]:.4g} s on, under '
            f'{imposed.drive[max(at - 1, 0)]:.4g} {CHANNELS[imposed.kind].unit} and '
            f'{imposed.load[max(at - 1, 0)]:.4g} N: this muscle would have burnt; are the units of the input '
            'right, and the parameters those of this muscle?'
        )
    return experiment.shown(outputs)


def refuse_still(experiments: Iterable[Experiment]) -> None:
    """BadInput where no channel of any recording moves: a fit would find numbers in nothing."""
    experiments = tuple(experiments)
    if any(_moves(observed.value) for e in experiments for observed in e.observed.values()):
        return
    channels = sorted({name for e in experiments for name in e.observed})
    driven = any(np.ptp(e.imposed.drive) > 0.0 for e in experiments)
    why = 'although the input changes: are the sensors connected?' if driven else 'and neither does the input'
    names = ', '.join(channels)
    raise BadInput(f'{experiments[0].name}: {names} do{"es" * (len(channels) == 1)} not move, {why}')


def _moves(value: Array) -> bool:
    """Whether the means of a channel's parts differ by more than its noise makes them."""
    parts = [part for part in np.array_split(value, _PARTS) if part.size]
    means = np.array([part.mean() for part in parts])
    noise = white_sigma(value) / float(np.sqrt(max(value.size // _PARTS, 1)))
    return bool(np.ptp(means) > max(_TWINKLES * noise, 1e-9 * float(np.max(np.abs(value), initial=0.0))))
