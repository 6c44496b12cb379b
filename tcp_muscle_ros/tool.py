"""The command line ``tcp_muscle``: one subcommand a file of commands/, loaded only when it is the one that runs.

Exit code: 0 done, 1 internal error, 2 bad input (one line on stderr, no traceback), 130 interrupted. A reader who has
seen enough (`| head`) changes nothing of what is done.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from typing import NoReturn

from tcp_muscle_ros import __version__
from tcp_muscle_ros.commands.exit_codes import BAD_INPUT, INTERNAL, INTERRUPTED
from tcp_muscle_ros.errors import BadInput, nearest
from tcp_muscle_ros.process.streams import forgiving
from tcp_muscle_ros.process.threads import one_of_linear_algebra

PROGRAM = 'tcp_muscle'
DEBUG = 'TCP_MUSCLE_DEBUG'

COMMANDS = {
    'simulate': ('simulate', 'simulate a protocol faster than real time, and write a bag'),
    'run': ('run', 'play a protocol on a running muscle, simulated or real, and record it'),
    'record': ('record', "record a muscle's topics to a bag"),
    'import': ('import_recordings', "convert a lab's files to bags, one per run"),
    'new-muscle': ('new_muscle', 'write a parameter file from fibre, coil and resistance'),
    'info': ('info', 'show what is in bags: channels, rates, ranges, problems'),
    'plot': ('plot', 'draw the channels of bags, one above the other'),
    'export': ('export', 'write a bag as CSV or Parquet'),
    'calibrate': ('calibrate', "fit the paper's parameters to recordings of a muscle, with intervals"),
    'replay': ('replay', 'drive the model with recorded inputs, and compare with the recording'),
    'diagnose': ('diagnose', 'find the physics that recordings show and the model lacks'),
    'investigate': (
        'investigate',
        'record, diagnose and run the proposed experiment until the cause is decided or the budget is spent',
    ),
}


class _Parser(argparse.ArgumentParser):
    """argparse whose errors are one line with the nearest valid choice."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f'{self.prog}: {message}; see {self.prog} --help\n')


def main(argv: Sequence[str] | None = None, *, until_admitted: bool = False) -> int:
    """Run ``tcp_muscle ARGV``; returns the exit code.

    ``until_admitted``: only as far as the command's inputs are known to be good; a command that does not tell this
    from its work runs as usual.
    """
    argv = list(sys.argv[1:] if argv is None else argv)
    one_of_linear_algebra()
    with forgiving() as lost:
        code = _guarded(argv, until_admitted)
    if lost:
        _say(PROGRAM, f'standard output cannot be written ({lost[0].strerror}): the output is incomplete')
        return code or BAD_INPUT
    return code


def _guarded(argv: list[str], until_admitted: bool) -> int:
    """Run the command; whatever goes wrong is one line and an exit code."""
    name = next((word for word in argv if not word.startswith('-')), None)
    if name is not None and name not in COMMANDS and not argv[0].startswith('-'):
        _say(PROGRAM, f"unknown command '{name}'{nearest(name, COMMANDS)}; see {PROGRAM} --help")
        return BAD_INPUT
    program = f'{PROGRAM} {name}' if name else PROGRAM
    try:
        return _run(argv, name, until_admitted)
    except SystemExit as leave:  # argparse has said what there is to say
        return leave.code if isinstance(leave.code, int) else BAD_INPUT
    except BadInput as error:
        _say(program, str(error))
        return BAD_INPUT
    except KeyboardInterrupt:
        _say(program, 'interrupted')
        return INTERRUPTED
    except Exception as error:
        if os.environ.get(DEBUG):
            raise
        if isinstance(error, OSError) and error.filename is not None:  # a name too long, a folder that may not be read
            _say(program, f'{error.filename}: {error.strerror}')
            return BAD_INPUT
        _say(program, f'internal error: {type(error).__name__}: {error} (set {DEBUG}=1 to see where, and report it)')
        return INTERNAL


def _run(argv: list[str], name: str | None, until_admitted: bool) -> int:
    parser = _Parser(
        prog=PROGRAM,
        description='Simulate, record, import, look at, calibrate, replay and diagnose TCP artificial muscles.',
    )
    parser.add_argument('--version', action='version', version=f'{PROGRAM} {__version__}')
    commands = parser.add_subparsers(title='commands', dest='command', metavar='COMMAND', required=True)
    module, own = None, parser
    for command, (file, purpose) in COMMANDS.items():
        subparser = commands.add_parser(command, help=purpose, description=purpose[0].upper() + purpose[1:] + '.')
        if command == name:
            try:
                module = importlib.import_module(f'tcp_muscle_ros.commands.{file}')
            except ModuleNotFoundError as error:
                return _missing(command, file, error)
            module.add_arguments(subparser)
            own = subparser
            _refuse_misspelt(subparser, argv[argv.index(command) + 1 :])
    args, unknown = parser.parse_known_args(argv)
    if unknown:
        own.error(f'unrecognized arguments: {" ".join(unknown)}')  # of the command, whose --help lists what it takes
    assert module is not None
    if until_admitted and hasattr(module, 'admit'):
        module.admit(args)
        return 0
    return int(module.run(args))


def _refuse_misspelt(parser: _Parser, words: Sequence[str]) -> None:
    """End at an option that is nearly one of the command's: argparse would only say that the right one is missing."""
    known = [option for option in parser._option_string_actions if option.startswith('--')]
    for word in words:
        option = word.partition('=')[0]
        if word == '--':
            return
        if option.startswith('--') and not any(one.startswith(option) for one in known):
            near = get_close_matches(option[2:], [one[2:] for one in known], n=1)
            if near:
                parser.error(f"unrecognized argument: {option}; did you mean '--{near[0]}'?")


def _missing(command: str, file: str, error: ModuleNotFoundError) -> int:
    """A command whose module, or a package that it needs, is not installed."""
    if error.name == f'tcp_muscle_ros.commands.{file}':
        _say(PROGRAM, f"'{command}' is not part of this version ({__version__})")
    else:
        _say(f'{PROGRAM} {command}', f"needs the Python package '{error.name}', which is not installed")
    return BAD_INPUT


def _say(program: str, sentence: str) -> None:
    print(f'{program}: {" ".join(sentence.split())}', file=sys.stderr)


if __name__ == '__main__':
    sys.exit(main())
