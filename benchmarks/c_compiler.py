"""Hand-written C, compiled in the benchmark: what the same arithmetic costs without numba and Python."""

import ctypes
import shutil
import subprocess
import tempfile
from pathlib import Path

FLAGS = ('-O3', '-march=native')


def compile_c(source: str) -> tuple[ctypes.CDLL | None, str]:
    """The library and the compiler's name, or None and why there is none."""
    compiler = shutil.which('cc') or shutil.which('gcc') or shutil.which('clang')
    if compiler is None:
        return None, 'no C compiler found (cc, gcc, clang)'
    with tempfile.TemporaryDirectory(prefix='benchmark_c_') as folder:
        (Path(folder) / 'loop.c').write_text(source)
        command = [compiler, *FLAGS, '-shared', '-fPIC', '-o', 'loop.so', 'loop.c', '-lm']
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            return None, f'{compiler} failed: {done.stderr.strip().splitlines()[-1]}'
        return ctypes.CDLL(str(Path(folder) / 'loop.so')), Path(compiler).name
