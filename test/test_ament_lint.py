"""What ament_lint holds a package of ROS 2 to. Its own programs run: those of a sourced ROS 2, else the wheels.

Of xmllint and copyright there are no wheels. Where a linter is missing ruff holds the same (pyproject.toml):
pycodestyle, pyflakes, docstrings. Docstrings follow PEP 257, but for what ``STYLE`` lists. ``ament_copyright`` asks for
a notice in each source file, which names who holds the copyright; a package made by ``ros2 pkg create`` leaves that
test out until there are such notices, and so does this one: LICENSE is checked alone.
"""

import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[1]
LINTED = ('tcp_muscle_ros', 'launch', 'scripts', 'setup.py')
# The class says what __init__ does (D107) and what its magic methods mean (D105). A summary says what something is as
# often as what it does (D401), may begin with a symbol of the physics (D402, D403), end with a colon or a question mark
# (D400) and run over two lines (D205); short texts end on their last line (D209).
STYLE = ('D105', 'D107', 'D205', 'D209', 'D400', 'D401', 'D402', 'D403')
# The order in which the schema of format 3 has the elements of package.xml.
ORDER = ('name', 'version', 'description', 'maintainer', 'license', 'url', 'author', 'depends', 'export')


def lint(linter, *arguments):
    pytest.importorskip(f'ament_{linter}', reason='ament_lint comes with a ROS 2 installation')
    done = subprocess.run(
        [sys.executable, '-m', f'ament_{linter}.main', *arguments], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, '\n'.join((done.stdout + done.stderr).splitlines()[-30:])


def test_ament_flake8():
    lint('flake8', '--config', 'test/ament_flake8.ini', *LINTED)


def test_ament_pep257():
    lint('pep257', '--convention', 'pep257', '--add-ignore', *STYLE, '--', 'tcp_muscle_ros')


def test_ament_pep257_of_launch_files_and_scripts():
    """Whose functions need no docstring, as nothing does by ament_pep257's own settings."""
    lint('pep257', '--convention', 'pep257', '--add-ignore', *STYLE, 'D100', 'D101', 'D102', 'D103', '--', *LINTED[1:])


def test_ament_xmllint():
    if shutil.which('xmllint') is None:
        pytest.skip('needs xmllint (libxml2-utils)')
    lint('xmllint', '--extensions', 'xml', 'xacro', 'urdf', '--', 'config', 'urdf', 'tcp_muscle_ros/robots/data')


def test_ament_copyright_knows_the_licence():
    parser = pytest.importorskip('ament_copyright.parser', reason='ament_lint comes with a ROS 2 installation')
    assert parser.parse_file(str(ROOT / 'LICENSE')).license_identifier == 'apache2'


@pytest.mark.parametrize(
    'path',
    sorted(path for ending in ('xml', 'xacro', 'urdf') for path in ROOT.glob(f'[!.]*/**/*.{ending}')),
    ids=lambda path: path.name,
)
def test_markup_is_well_formed(path):
    ElementTree.parse(path)


def test_package_xml_is_what_format_3_allows():
    children = [element.tag for element in ElementTree.parse(ROOT / 'package.xml').getroot()]
    places = [ORDER.index('depends' if tag.endswith('depend') else tag) for tag in children]
    assert places == sorted(places)
    package = pytest.importorskip('catkin_pkg.package', reason='comes with colcon')
    warnings = []
    package.parse_package(str(ROOT), warnings=warnings).validate(warnings=warnings)
    assert warnings == []
