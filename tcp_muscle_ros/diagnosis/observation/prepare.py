"""Make a recording ready for the model."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tcp_muscle_ros.diagnosis.observation.blocks import averaged, coarsened, instants_of, switches
from tcp_muscle_ros.diagnosis.observation.experiment import Experiment
from tcp_muscle_ros.diagnosis.observation.holding import Conditions, holding_of
from tcp_muscle_ros.diagnosis.observation.imposed import FOLLOWS_SETPOINT, Imposed, driven
from tcp_muscle_ros.diagnosis.observation.input_noise import quiet, still_air, which_is_held
from tcp_muscle_ros.diagnosis.observation.observed import Observed
from tcp_muscle_ros.diagnosis.observation.quotient import beside, nearest_reading, quotient
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording import options
from tcp_muscle_ros.recording.inputs import changes, drive_of, hold, stated_ambient
from tcp_muscle_ros.recording.mending import FEWEST
from tcp_muscle_ros.recording.plausibility import not_across
from tcp_muscle_ros.recording.recording import CHANNELS, OUTPUTS, Channel, Recording, shared

_SELDOM = 0.01  # of the samples: an input that changes no more often is constant between its steps


def prepare(
    recording: Recording, nominal: Parameters, conditions: Conditions | None = None, most: int | None = None
) -> Experiment:
    """Make a recording ready for the model.

    Args:
        recording: channels in SI.
        nominal: the muscle as assumed; gives the ambient (T0) where nothing else does.
        conditions: what the user states about the run.
        most: the largest number of observations a channel; longer ones are averaged in blocks.

    Raises:
        BadInput: no input, no output, or too few samples of them.
    """
    conditions = conditions or Conditions()
    notes: list[str] = list(recording.notes)
    of_muscle = _without_other_voltage(recording, notes)
    kind, drive = _source(of_muscle, _drive(of_muscle))
    observed, steady = _outputs(of_muscle, notes)
    holding, load, used = holding_of(recording, observed, conditions, notes, _off_until(drive))
    if used is not None:
        observed.pop(used, None)
    if not observed:
        raise BadInput(
            f'{recording.path}: nothing to compare: expected at least one of {", ".join(OUTPUTS)} beside {kind}'
        )
    known = dict(recording.known)
    if len(recording.channels.get('displacement_setpoint', ())):
        known[FOLLOWS_SETPOINT] = True
    else:  # a controller imposes what it makes of the noise of its sensor
        drive, noise = quiet(drive)
        if noise:
            unit = CHANNELS[kind].unit
            notes.append(f'the noise of the {kind} was averaged out between its steps: {noise:.2g} {unit}')
    if kind == 'power':  # what a wattmeter reads below zero is its noise
        drive = replace(drive, value=np.maximum(drive.value, 0.0))
    between, lost = switches(drive)
    drive = coarsened(drive, most, 1.0 if kind == 'power' else 2.0)
    load = coarsened(load, most, 1.0)
    start = max(float(drive.time[0]), 0.0)
    blocks: dict[str, Observed] = {}
    for name, channel in observed.items():
        made = averaged(channel, drive, load, most, start)
        if made.time.size < FEWEST:
            notes.append(f'{name}: {made.time.size} values since the {kind} began ({start:.4g} s), too few: left out')
            continue
        weighs = nearest_reading(steady[name], made.time) if name in steady else None
        time = shared(made.time, (other.time for other in blocks.values()))
        blocks[name] = replace(made, time=time, steady=weighs)
    if not blocks:
        raise _nothing_since(recording, kind, start, observed)
    end = max(float(observed[name].time[-1]) for name in blocks)
    grid = instants_of([channel.time for channel in blocks.values()], drive, load, start, end)
    between, lost = (found[(found[:, 0] >= start) & (found[:, 1] <= end)] for found in (between, lost))
    room = stated_ambient(recording, conditions.ambient)
    air, unsure, unread = _air(recording, nominal['T0'] if room is None else room)
    pull = np.maximum(hold(load, grid), 0.0) if isinstance(load, Channel) else hold(load, grid)
    imposed = Imposed(kind, grid, hold(drive, grid), pull, hold(air, grid), between, lost, unsure, unread)
    experiment = Experiment(recording.path, imposed, holding, blocks, known, tuple(notes), recording.start_ns)
    return replace(experiment, fingerprint=recording.fingerprint)


def _off_until(drive: Channel) -> float:
    """When the drive first comes on, s; 0 where it is on from the start."""
    on = np.flatnonzero(driven(drive.value))
    return float(drive.time[on[0]]) if on.size and on[0] > 0 else 0.0


def _nothing_since(recording: Recording, kind: str, start: float, observed: Mapping[str, Channel]) -> BadInput:
    """What is wrong with a recording of which no channel has enough values since its drive began."""
    end, names = max(float(channel.time[-1]) for channel in observed.values()), ', '.join(observed)
    if end <= start:
        return BadInput(
            f'{recording.path}: {kind} begins at {start:.4g} s, after the last of {names} ({end:.4g} s): '
            'are these of one recording, and of one clock?'
        )
    return BadInput(f'{recording.path}: fewer than {FEWEST} values of {names} since the {kind} began ({start:.4g} s)')


def _without_other_voltage(recording: Recording, notes: list[str]) -> Recording:
    """The recording without a voltage that is not across the muscle, which would give no power and no resistance; a
    note says so."""
    voltage, current = recording.channels.get('voltage'), recording.channels.get('current')
    if voltage is None or current is None or not len(voltage) or not len(current):
        return recording
    # A current may be logged where it changes, or beside the voltage: none flows where both ways to read it say so.
    flowing = np.maximum(np.abs(hold(current, voltage.time)), np.abs(nearest_reading(current, voltage.time)))
    why = not_across(voltage.value, flowing)
    if not why:
        return recording
    notes.append(f'the voltage is not that across the muscle and was left out, the current drives: {why}')
    return replace(recording, channels={name: recording[name] for name in recording if name != 'voltage'})


def _drive(recording: Recording) -> Channel:
    """The input that was applied; the commanded one where the applied was not recorded."""
    drive = drive_of(recording)
    if drive is None:
        raise BadInput(
            f'{recording.path}: no input recorded: expected a channel current, power or voltage (name one with ',
            options.some_channel('current'),
            ')',
        )
    return drive


def _source(recording: Recording, drive: Channel) -> tuple[str, Channel]:
    """What the source holds, and of which kind it is: where it holds a power or a voltage, the current changes with the
    resistance between two samples too."""
    voltage = recording.channels.get('voltage')
    if drive.name != 'current' or voltage is None or len(voltage) < 2:
        return drive.name.removesuffix('_command'), drive
    if changes(drive).size <= _SELDOM * len(drive):
        return drive.name, drive
    across, through = beside(voltage, drive)  # a log of changes changes at each stamp, whatever is held
    power = replace(through, name='power', value=through.value * nearest_reading(across, through.time))
    chosen = (drive, power, voltage)[which_is_held((through, power, across))]
    return chosen.name, chosen


def _outputs(recording: Recording, notes: list[str]) -> tuple[dict[str, Channel], dict[str, Channel]]:
    """The outputs that were recorded, a resistance also as voltage over current, and what readings weigh by their noise
    where that differs; notes say so."""
    observed = {name: recording[name] for name in OUTPUTS if name in recording and len(recording[name]) > 1}
    if 'resistance' in observed or not {'voltage', 'current'} <= set(recording.channels):
        return observed, {}
    derived = quotient(recording['voltage'], recording['current'], 'resistance')
    if derived is None:
        return observed, {}
    notes.append('resistance was derived as voltage over current')
    if derived.least:
        notes.append(
            f'where less than {derived.least:.2g} A flowed, resistance was left out: '
            'the noise of voltage and current hides it'
        )
    return {**observed, 'resistance': derived.ohms}, {'resistance': derived.steady}


def _air(recording: Recording, otherwise: float) -> tuple[Channel | float, float, bool]:
    """The room as its thermometer read it without its noise, else as stated (K); what is unsure of a reading, K; and
    whether there is none."""
    read = recording.channels.get('ambient')
    if read is None or not len(read):
        return otherwise, 0.0, True
    air, unsure = still_air(read)
    return air, unsure, False
