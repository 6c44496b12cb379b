"""``tcp_muscle investigate --output DIR``: find out what a muscle lacks in its simulation, without a person.

It records a first protocol, diagnoses, records the experiment that the diagnosis proposes, diagnoses all so far, until
that is decided or the budget is spent. A last run is kept back and says how well the found muscle predicts it.
"""

from __future__ import annotations

import argparse
import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from tcp_muscle_ros.commands.bag_arguments import (
    add_channel_argument,
    add_unit_argument,
    other_topics,
    read_bags,
    reading_options,
    stated_units,
)
from tcp_muscle_ros.commands.exit_codes import INTERRUPTED
from tcp_muscle_ros.commands.model_arguments import add_parameter_argument
from tcp_muscle_ros.commands.plants import Live, Simulated, in_own_process
from tcp_muscle_ros.commands.run import add_rig_arguments, allowed_by, driver_allows, rig_limits
from tcp_muscle_ros.errors import BadInput
from tcp_muscle_ros.files.outputs import add_force_argument

if TYPE_CHECKING:
    from tcp_muscle_ros.commands.investigation import Investigation
    from tcp_muscle_ros.control.playing import Allowed
    from tcp_muscle_ros.muscle import Parameters
    from tcp_muscle_ros.recording.protocol import Protocol
    from tcp_muscle_ros.recording.recording import Recording
    from tcp_muscle_ros.settings.rig import RigLimits

_LEAST_IMPROVED = 1e-12
_SETTINGS = 'settings.json'
_FILES = ('params', 'first', 'simulated', 'rig')
_FIXED = (*_FILES, 'namespace', 'channel', 'unit')  # what no resumed investigation may change, and
_SPENT = ('minutes', 'runs', 'cycles', 'yes')  # what it may


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``investigate``."""
    add_parameter_argument(parser)
    parser.add_argument('--output', required=True, metavar='DIR', help='a new folder for runs, reports and the log')
    parser.add_argument('--resume', action='store_true', help='continue one that was stopped, as it was begun')
    add_force_argument(parser)
    parser.add_argument(
        '--first',
        metavar='PROTOCOL.yaml',
        help='record this first (default: six, 22 min; four, 14 min, where the load stays)',
    )
    parser.add_argument(
        '--minutes', type=float, default=90.0, metavar='N', help='most minutes on the muscle (default: 90)'
    )
    parser.add_argument(
        '--runs', type=int, default=20, metavar='N', help='most runs, the one kept back included (default: 20)'
    )
    parser.add_argument('--cycles', type=int, default=1000, metavar='N', help='most heating cycles (default: 1000)')
    parser.add_argument('--simulated', metavar='MUSCLE.yaml', help='use a simulated muscle, to try the command out')
    add_rig_arguments(parser)
    add_channel_argument(parser)
    add_unit_argument(parser)
    usual = {name: parser.get_default(name) for name in (*_FIXED, *_SPENT)}
    parser.set_defaults(usual=usual, **dict.fromkeys(usual))  # None: it was not given


class Admitted(NamedTuple):
    """What an investigation needs, once all of it is known to be good: ``args`` are those that it was begun with."""

    args: argparse.Namespace
    folder: Path
    begin: Callable[[], Investigation]


def admit(args: argparse.Namespace) -> Admitted:
    """All that can be refused before anything is recorded."""
    from tcp_muscle_ros.files.outputs import refuse_among, writable_folder
    from tcp_muscle_ros.settings.parameter_file import read

    folder = Path(args.output)
    if args.resume:
        if args.force:
            raise BadInput('--resume continues an investigation, --force begins anew; expected one of them')
        args = _complete(args, _settings(folder))
    else:
        args = _complete(args)
        refuse_among(folder, filter(None, (args.params, args.rig, args.first, args.simulated)))
        ours = args.force and (folder / _SETTINGS).is_file() and (folder / 'log.jsonl').is_file()
        if not ours:
            writable_folder(folder, force=args.force)
    stated_units(args)
    if other_topics(args) and args.simulated:
        raise BadInput(f'--channel {args.channel[0]}: a simulated muscle has no topic beside its own')
    if args.simulated:
        read(args.simulated)
    return Admitted(args, folder, _investigation(args, folder, read(args.params).parameters, rig_limits(args.rig)))


def run(args: argparse.Namespace) -> int:
    """Investigate, or go on; 130 where it was interrupted."""
    from tcp_muscle_ros.files.outputs import remove, set_aside
    from tcp_muscle_ros.process.compiling import tell_of_compiling

    tell_of_compiling()
    args, folder, begin = admit(args)
    if args.resume:
        replaced = _settings(folder).get('replaces')
    else:
        before = set_aside(folder, 'before')
        replaced = before.name if before else ''
        folder.mkdir(parents=True)
    _keep(folder, {**{name: getattr(args, name) for name in args.usual}, 'replaces': replaced})
    try:
        investigation = begin()
        investigation.run()
    except KeyboardInterrupt:
        _say(f'{folder}: interrupted; --resume goes on')
        return INTERRUPTED
    _conclude(args, investigation, folder)
    if replaced:
        remove(folder.with_name(replaced))
    return 0


def _settings(folder: Path) -> dict[str, Any]:
    """What an investigation was begun with. BadInput where the folder is none of one."""
    try:
        settings = json.loads((folder / _SETTINGS).read_text(encoding='utf-8'))
    except (OSError, ValueError):
        settings = None
    if not isinstance(settings, dict):
        raise BadInput(f'--resume: {folder} is no folder of an investigation')
    return settings


def _keep(folder: Path, settings: Mapping[str, object]) -> None:
    """Write down what an investigation was begun with; files so that they are found from any folder."""
    files = {name: settings[name] for name in _FILES if settings[name] and Path(str(settings[name])).is_file()}
    known = {**settings, **{name: str(Path(str(file)).absolute()) for name, file in files.items()}}
    draft = (folder / _SETTINGS).with_suffix('.draft')
    draft.write_text(json.dumps(known, indent=1) + '\n', encoding='utf-8')
    draft.replace(folder / _SETTINGS)


def _complete(args: argparse.Namespace, begun: Mapping[str, object] | None = None) -> argparse.Namespace:
    """The arguments with what is usual where they say nothing; of one that is resumed with what it was ``begun`` with.

    BadInput where they name another muscle than that. Another budget may be given.
    """
    given, before = (
        {name: source[name] for name in args.usual if source.get(name) is not None}
        for source in (vars(args), begun or {})
    )
    stored = {**args.usual, **before}
    for name in _FIXED if begun is not None else ():
        if name in given and not _same(given[name], stored[name]):
            was = f"'{_typed(stored[name])}'" if stored[name] else 'none'
            raise BadInput(f"--resume: --{name} '{_typed(given[name])}' is not that which it was begun with ({was})")
    return argparse.Namespace(**{**vars(args), **stored, **given})


def _typed(value: object) -> str:
    return ' '.join(value) if isinstance(value, list) else str(value)


def _same(one: object, other: object) -> bool:
    """Do two arguments name the same file, set or namespace?"""
    return one == other or (bool(one and other) and Path(str(one)).resolve() == Path(str(other)).resolve())


def _investigation(
    args: argparse.Namespace, folder: Path, model: Parameters, limits: RigLimits | None
) -> Callable[[], Investigation]:
    """What makes the investigation in its folder, once the muscle's driver has said what it allows. BadInput where it
    may not be begun."""
    from tcp_muscle_ros.commands.investigation import Budget, Investigation, Log, allowed_of

    if not (args.minutes > 0.0 and args.runs >= 2 and args.cycles >= 1):
        raise BadInput('expected --minutes above 0, --runs of 2 or more (one is kept back) and --cycles of 1 or more')
    by_rig = allowed_by(limits, None)
    of_rig = _protocols(args, model, limits, by_rig)
    budget = Budget(60.0 * args.minutes, args.runs, args.cycles)

    def begin() -> Investigation:
        log = Log(folder)
        played = log.ended(budget) and log.of('kept_back')  # nothing more is
        asked = not args.simulated and not played
        allowed = driver_allows(limits, args.namespace, 'current', _say) if asked else by_rig
        rounds, kept = of_rig if allowed == by_rig else _protocols(args, model, limits, allowed)
        return Investigation(
            folder,
            Simulated(args.simulated, folder) if args.simulated else Live(args, model, limits, _say),
            lambda bags, report: _diagnosed(bags, report, args),
            rounds,
            kept,
            lambda protocol: allowed_of(protocol, model, allowed),
            budget,
            _say,
        )

    return begin


def _protocols(
    args: argparse.Namespace, model: Parameters, limits: RigLimits | None, allowed: Allowed
) -> tuple[list[list[Protocol]], Protocol]:
    """What is recorded round by round, and the run that is kept back, with the current that is allowed."""
    from tcp_muscle_ros.commands.exploring import first_protocols, further_protocols, kept_back_protocol, loads_about
    from tcp_muscle_ros.commands.investigation import allowed_of
    from tcp_muscle_ros.muscle import ZERO_CELSIUS
    from tcp_muscle_ros.recording.protocol import read_protocol
    from tcp_muscle_ros.settings.operating import OPERATING
    from tcp_muscle_ros.settings.parameter_file import read

    file = read(args.params)
    current = min(allowed.current, float(OPERATING['current_limit_a'].default))  # type: ignore[arg-type]
    load, ambient = file.number('load_n'), file.number('ambient_temperature_c') + ZERO_CELSIUS
    if allowed.loads:
        load = min(allowed.loads, key=lambda one: abs(one - load))
    by_itself = bool(args.simulated or args.yes or (limits is not None and not limits.by_person))
    loads = loads_about(load, allowed.loads) if by_itself else (load,)
    first = [read_protocol(args.first)] if args.first else first_protocols(current, loads, load, ambient)
    if not args.first:
        first = _short(first, allowed.duration) or first  # all too long: refused below
    further = (_short(those, allowed.duration) for those in further_protocols(current, loads, load, ambient))
    rounds = [first, *filter(None, further)]
    kept = kept_back_protocol(current, load, ambient)
    return [[allowed_of(one, model, allowed) for one in those] for those in rounds], allowed_of(kept, model, allowed)


def _short(protocols: Sequence[Protocol], longest: float) -> list[Protocol]:
    """Those that a rig has the time for (s): what the others would show is asked for by the diagnosis, if at all."""
    return [protocol for protocol in protocols if protocol.duration <= longest]


def _diagnosed(bags: Sequence[Path], report: Path, args: argparse.Namespace) -> Mapping[str, Any]:
    """``tcp_muscle diagnose`` in a process of its own: its memory is free again afterwards.

    That of an investigation that was killed goes on, and may leave the same report there meanwhile.
    """
    known = ('--rig', args.rig) if args.rig else ()
    how = (*known, *reading_options(_as_recorded_by(args)))
    in_own_process('diagnose', *map(str, bags), '--params', args.params, *how, '--force', '--output', str(report))
    content: Mapping[str, Any] = json.loads((report / 'report.json').read_text(encoding='utf-8'))
    return content


def _as_recorded_by(args: argparse.Namespace) -> argparse.Namespace:
    """How its bags are read: those of a simulated muscle have no namespace."""
    namespace = None if args.simulated else args.namespace or None
    return argparse.Namespace(namespace=namespace, channel=args.channel, unit=args.unit)


def _conclude(args: argparse.Namespace, investigation: Investigation, folder: Path) -> None:
    """The report over all runs, the muscle that was found, and how well it predicts the run that was kept back."""
    from tcp_muscle_ros.files.outputs import remove

    last = investigation.last_report
    for name in ('report', 'improved.yaml', 'improved.intervals.json', 'improved.ages.json'):
        source, place = (last if name == 'report' else last / name), folder / name
        remove(place)  # of a conclusion before, where the budget was smaller
        if source.is_dir():
            shutil.copytree(source, place)
        elif source.is_file():
            shutil.copyfile(source, place)
    improved, rig = folder / 'improved.yaml', folder / 'report' / 'rig.yaml'
    kept = read_bags(_as_recorded_by(args), *map(str, investigation.kept_back))
    before = _errors(kept, args.params, args.rig)
    after = _errors(kept, str(improved), rig) if improved.is_file() else before
    summary = {
        'why': investigation.log.of('end')[-1]['why'],
        'headline': investigation.log.of('diagnosis')[-1]['headline'],
        'runs': len(investigation.log.of('run')),
        'muscle_time_s': sum(one['duration_s'] for step in ('run', 'kept_back') for one in investigation.log.of(step)),
        'kept_back': {name: {'rmse_before': before[name], 'rmse_after': after[name]} for name in before},
    }
    (folder / 'summary.json').write_text(json.dumps(summary, indent=1) + '\n')
    _say(f'{folder}: {summary["headline"]} ({summary["why"]}; {summary["runs"]} runs)')
    for name in before:
        share = after[name] / max(before[name], _LEAST_IMPROVED)
        _say(f'kept-back run, {name}: {share:.3f} times the error of the model that it began with')


def _errors(recordings: Sequence[Recording], params: str, rig: str | Path | None) -> dict[str, float]:
    """Root mean square error of each channel over recordings, SI, as ``tcp_muscle replay`` has it."""
    from tcp_muscle_ros.diagnosis.answer.replaying import ReplayedErrors
    from tcp_muscle_ros.diagnosis.observation.observe import conditions
    from tcp_muscle_ros.settings.ages import as_recorded
    from tcp_muscle_ros.settings.parameter_file import read
    from tcp_muscle_ros.settings.rig import read_rig

    file, known, errors = read(params), read_rig(rig) if rig else None, ReplayedErrors()
    for recording in recordings:
        muscle = as_recorded(file.parameters, params, known, recording)
        errors.add_as_read(recording, file.parameters, conditions(file), muscle)
    return errors.rmse()


def _say(sentence: str) -> None:
    print(sentence, flush=True)
