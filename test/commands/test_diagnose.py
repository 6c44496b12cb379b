"""``tcp_muscle diagnose``: what it adds to a diagnosis from the recordings themselves."""

import numpy as np
from report.diagnoses import match

from tcp_muscle_ros.commands.diagnose import with_issues
from tcp_muscle_ros.diagnosis.experiment import prepare
from tcp_muscle_ros.muscle import Parameters
from tcp_muscle_ros.recording.recording import Channel, Recording


def test_the_checks_of_the_recordings_are_in_the_report():
    diagnosis, (made,) = match()
    channels = {name: Channel(name, o.time, o.value, name) for name, o in made.observed.items()}
    time = made.imposed.time
    channels['current'] = Channel('current', time, made.imposed.drive, 'current')
    stroke = channels['displacement']
    kept = (stroke.time < 100.0) | (stroke.time > 112.0)
    channels['displacement'] = Channel('displacement', stroke.time[kept], stroke.value[kept], 'displacement')
    recording = Recording('bag', channels, 0, {}, ('the bag was cut short',))
    experiment = prepare(recording, Parameters.named('karami_tadesse_2017'), most=1000)

    (summary,) = with_issues(diagnosis, [recording], [experiment]).recordings
    told = '\n'.join(summary.issues)
    assert 'displacement: no sample for 12.2 s from 99.900 s' in told
    assert 'no load was recorded or stated: taken as 0 N' in told
    assert 'averaged in blocks of up to so many samples: temperature (4)' in told
    assert summary.issues.count('the bag was cut short') == 1
    assert np.isfinite(summary.duration)

    again = with_issues(with_issues(diagnosis, [recording], [experiment]), [recording], [experiment])
    assert again.recordings == (summary,)
