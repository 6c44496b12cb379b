"""What is compiled ahead is what a start needs."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from numba.core import caching

import tcp_muscle_ros.muscle
from tcp_muscle_ros.muscle.compiled import CACHE

AHEAD = 'from tcp_muscle_ros.muscle.ahead import compile_ahead; compile_ahead()'
USE = """
import sys
import numpy as np
from tcp_muscle_ros.control.tracking import TrackingController
from tcp_muscle_ros.muscle import Muscle, Muscles, Parameters, length, simulate, tension

model = Parameters.named('karami_tadesse_2017').with_effects('creep', 'hysteresis', 'inertia', 'two_node')
Muscles([Muscle(model, load=0.5, end=end, spring_rate=10.0) for end in ('load', 'spring')]).step(0.01, [0.1, 0.1])
Muscle(model, end='blocked').step(0.01, 1.0, 'voltage')
simulate(model, np.arange(5) * 0.1, np.full(5, 0.1), load=[0.5] * 5, resolution=0.2)
TrackingController(model, 0.01, 0.27, 0.5, 300.0).update(0.01, displacement=0.0)
tension(model, float(length(model, 300.0, 0.2)), 310)
entries = {
    value
    for name, module in list(sys.modules.items()) if name.startswith('tcp_muscle_ros')
    for value in vars(module).values() if hasattr(value, 'py_func') and value.signatures
}
used = {entry.__name__: entry.stats for entry in entries if entry.stats.cache_hits or entry.stats.cache_misses}
print(sorted(used), sum(sum(stats.cache_misses.values()) for stats in used.values()))
"""


def test_after_compiling_ahead_nothing_is_compiled_when_a_node_or_a_fit_starts():
    subprocess.run([sys.executable, '-c', AHEAD], check=True, timeout=300)
    used = subprocess.run([sys.executable, '-c', USE], check=True, timeout=300, capture_output=True, text=True).stdout
    statics = ['_branch', '_invert', '_length', '_lengths', '_pull']
    names = [*statics, 'advance', 'advance_many', 'reference_modulus', 'run', 'settle']
    assert used.strip() == f'{names} 0'


def installed_elsewhere(tmp_path):
    """A copy of the package with its machine code, as an installation has it; numba names folders after the place."""
    home = Path(tcp_muscle_ros.muscle.__file__).parents[1]
    copy = tmp_path / 'site' / 'tcp_muscle_ros'
    ignored = shutil.ignore_patterns('__pycache__', 'config')
    shutil.copytree(home, copy, ignore=ignored)
    subpath = caching.UserProvidedCacheLocator.get_suitable_cache_subpath
    code = CACHE / subpath(str(home / 'muscle' / 'stepping.py'))
    shipped = copy / 'muscle' / 'machine_code' / CACHE.name
    shutil.copytree(code, shipped / subpath(str(copy / 'muscle' / 'stepping.py')))
    return copy


def test_an_installation_that_brings_machine_code_compiles_nothing_and_is_not_written_to(tmp_path):
    subprocess.run([sys.executable, '-c', AHEAD], check=True, timeout=300)
    copy = installed_elsewhere(tmp_path)
    before = {path: path.stat().st_mtime_ns for path in copy.rglob('*')}
    environment = {**os.environ, 'PYTHONPATH': str(copy.parent), 'PYTHONDONTWRITEBYTECODE': '1'}
    for home in ('one', 'another'):
        environment['XDG_CACHE_HOME'] = str(tmp_path / home)
        program = 'import tcp_muscle_ros; print(tcp_muscle_ros.__file__)\n' + USE
        done = subprocess.run(
            [sys.executable, '-c', program], env=environment, cwd=tmp_path, check=True, capture_output=True, text=True
        )
        place, used = done.stdout.splitlines()
        assert Path(place).parent == copy
        assert used.endswith(' 0') and 'advance' in used, 'something was compiled'
    assert {path: path.stat().st_mtime_ns for path in copy.rglob('*')} == before


def test_whether_all_is_compiled_is_known_for_this_place(tmp_path):
    program = 'from tcp_muscle_ros.muscle.ahead import is_compiled; print(is_compiled())'
    subprocess.run([sys.executable, '-c', AHEAD], check=True, timeout=300)
    usual = os.environ.get('XDG_CACHE_HOME') or str(Path.home() / '.cache')
    for home, expected in ((usual, 'True'), (str(tmp_path), 'False')):
        environment = {**os.environ, 'XDG_CACHE_HOME': home}
        done = subprocess.run(
            [sys.executable, '-c', program], env=environment, check=True, capture_output=True, text=True
        )
        assert done.stdout.strip() == expected
