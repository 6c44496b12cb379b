import os
import subprocess
import sys
import tempfile
from glob import glob
from pathlib import Path

from setuptools import find_packages, setup
from setuptools.command.develop import develop
from setuptools.command.install import install

NAME = 'tcp_muscle_ros'
HERE = Path(__file__).resolve().parent  # through the link that colcon build --symlink-install makes


def pinned(name):
    """The requirements of one file of requirements/, without comments."""
    lines = (HERE / 'requirements' / name).read_text(encoding='utf-8').splitlines()
    return [line for line in lines if line and not line.startswith(('#', '-'))]


def version():
    text = (HERE / NAME / '__init__.py').read_text(encoding='utf-8')
    return text.split("__version__ = '")[1].split("'")[0]


def compile_model(library, *options, **environment):
    """Compile the model of the package as it will be imported from ``library``; where that fails, only say so."""
    path = os.pathsep.join(filter(None, [str(library), os.environ.get('PYTHONPATH')]))
    # `python -m` puts the folder it runs in first on the path: an empty one, for a /tmp/re.py would be taken for `re`.
    with tempfile.TemporaryDirectory() as empty:
        done = subprocess.run(
            [sys.executable, '-m', f'{NAME}.robots', *options],
            env={**os.environ, 'PYTHONPATH': path, **environment},
            cwd=empty,
            capture_output=True,
            text=True,
            check=False,
        )
    if done.returncode:
        why = (done.stderr.strip().splitlines() or ['no reason given'])[-1]
        print(f'the model was not compiled, so the first start does it: {why}', file=sys.stderr)


class Install(install):
    """An installation in place, as `colcon build` makes it, has the model compiled into it: no start waits for that.

    Not where it is staged for an archive (a wheel, a .deb): another processor may unpack it.
    """

    def run(self):
        super().run()
        if self.root is not None:
            return
        library = Path(self.install_lib).resolve()
        for file in (library / NAME).rglob('*.py'):
            # numba holds machine code against the date of its source; archives and containers keep whole seconds.
            os.utime(file, (int(file.stat().st_mtime),) * 2)
        with tempfile.TemporaryDirectory() as cache:
            compile_model(library, '--ship', XDG_CACHE_HOME=cache)


class Develop(develop):
    """`colcon build --symlink-install` leaves the code where it is edited: its machine code is in the user's cache."""

    def run(self):
        super().run()
        # As colcon calls it, from the folder that it puts on the path. From setuptools 80 on it has another `develop`
        # without --editable, and colcon installs instead.
        if getattr(self, 'editable', False) and not self.uninstall:
            compile_model(Path.cwd())


setup(
    name=NAME,
    cmdclass={'develop': Develop, 'install': Install},
    version=version(),
    description='Twisted and coiled polymer (TCP) artificial muscles in ROS 2',
    long_description=(HERE / 'README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    maintainer='The tcp_muscle_ros maintainers',
    maintainer_email='maintainers@tcp-muscle-ros.example.org',
    license='Apache-2.0',
    python_requires='>=3.10',
    packages=find_packages(include=[NAME, NAME + '.*']),
    # The package sees config/ through the link tcp_muscle_ros/config, so that every way of installing it
    # (a wheel, `pip install -e`, colcon with or without symlinks) finds the same files beside the code.
    package_data={NAME: ['py.typed', 'config/*', 'report/*.json', 'report/templates/*', 'robots/data/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
        ('share/' + NAME + '/config', sorted(glob('config/*'))),
        ('share/' + NAME + '/launch', sorted(glob('launch/*.launch.py'))),
        ('share/' + NAME + '/urdf', sorted(glob('urdf/*'))),
    ],
    zip_safe=False,
    # The oldest versions of ROS 2 Jazzy's Ubuntu (24.04); what scripts/ installs is pinned in requirements/.
    install_requires=[
        'setuptools',
        'numpy>=1.26',
        'scipy>=1.11',
        'numba>=0.60',
        'matplotlib>=3.6',
        'Jinja2>=3.1',
        'PyYAML>=6.0',
        'rosbags>=0.11,<0.12',
        'mcap>=1.3',
        'lz4>=4.0',
        'zstandard>=0.22',
    ],
    extras_require={
        'ros': pinned('ros.txt'),
        'bench': pinned('bench.txt'),
        'cluster': ['distributed>=2024.1'],
        'hardware': ['pyserial>=3.5'],
        'labs': ['pandas>=2.1', 'openpyxl>=3.1', 'pyarrow>=15.0', 'threadpoolctl>=3.1'],
        'mujoco': ['mujoco>=3.2; python_version >= "3.11"'],
        'test': ['pytest', 'hypothesis', 'psutil', 'jsonschema'],
    },
    entry_points={
        'console_scripts': [
            'sim_node = tcp_muscle_ros.nodes.entry:sim_node',
            'controller_node = tcp_muscle_ros.nodes.entry:controller_node',
            'twin_node = tcp_muscle_ros.nodes.entry:twin_node',
            'serial_driver_node = tcp_muscle_ros.nodes.entry:serial_driver_node',
            'tcp_muscle = tcp_muscle_ros.tool:main',
        ],
    },
)
