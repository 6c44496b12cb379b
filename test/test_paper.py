"""docs/paper.md says what the code computes: its tables, the numbers in its sentences, and where things are."""

import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
DOCUMENT = ROOT / 'docs' / 'paper.md'
TEXT = DOCUMENT.read_text(encoding='utf-8')
BLOCK = re.compile(r'<!-- table: (\w+) -->\n(.*?)<!-- end -->', re.DOTALL)
# What the paper itself states, and the edges of the model's domain.
QUOTED = {'0.15', '0.2', '0.75', '0.18', '0.27', '1', '10', '23', '25', '30', '40', '45', '50', '60', '75', '80',
          '100', '120', '1000'}  # fmt: skip


@pytest.fixture(scope='module')
def script():
    return runpy.run_path(str(ROOT / 'scripts' / 'paper_tables.py'))


def test_every_table_is_what_the_code_prints_now(script):
    assert script['updated'](TEXT) == TEXT, 'run: python scripts/paper_tables.py --update'
    assert {name for name, _ in BLOCK.findall(TEXT)} == set(script['TABLES'])


def test_every_number_in_a_sentence_is_one_that_the_code_prints():
    printed = {number for _, block in BLOCK.findall(TEXT) for number in re.findall(r'\d+\.?\d*', block)}
    prose = re.sub(r'```.*?```', '', BLOCK.sub('', TEXT), flags=re.DOTALL)
    decimals = re.findall(r'(?<![\w.])\d+\.\d+', prose)
    with_unit = re.findall(r'(?<![\w.])(\d+\.?\d*) (?:°C|K|A|W/K|N|N/m|mm|g|s|%|Ω)(?!\w)', prose)
    assert len(decimals) > 20 and len(with_unit) > 30
    assert not sorted({*decimals, *with_unit} - printed - QUOTED)


def test_every_equation_has_its_row():
    rows = re.findall(r'^\| (\d+|Table 1|text) (?:\|[^|]*){4}\|$', TEXT, re.MULTILINE)
    assert [row for row in rows if row.isdigit()] == [str(number) for number in range(1, 29)]
    assert 'Table 1' in rows and 'text' in rows


def test_files_and_names_exist(script):
    for name in set(re.findall(r'`(\w+\.py)`', TEXT)):
        assert list((ROOT / 'tcp_muscle_ros' / 'muscle').rglob(name)), name
    for name in re.findall(r'`(karami_\w+)`', TEXT):
        assert name in script['SETS']
    for path in re.findall(r'\]\((\S+?)\)', TEXT):
        assert (DOCUMENT.parent / path).is_file(), path
