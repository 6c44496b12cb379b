"""The plotting layouts show topics and fields of the contract, and nothing else."""

import json
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[1]
# contracts: topic -> the field that a plot shows
FIELDS = {
    '/displacement': 'data',
    '/displacement_setpoint': 'data',
    '/current': 'data',
    '/current_command': 'data',
    '/temperature': 'temperature',
    '/ambient_temperature': 'temperature',
    '/resistance': 'data',
    '/force': 'data',
    '/load': 'data',
}


def test_plotjuggler_curves():
    root = ElementTree.parse(ROOT / 'config' / 'plotjuggler_layout.xml').getroot()
    curves = {curve.get('name') for curve in root.iter('curve')}
    assert curves == {f'{topic}/{field}' for topic, field in FIELDS.items()}
    splitter = root.find('.//DockSplitter')
    assert int(splitter.get('count')) == len(splitter) == len(splitter.get('sizes').split(';'))


def test_foxglove_panels():
    layout = json.loads((ROOT / 'config' / 'foxglove_layout.json').read_text(encoding='utf-8'))
    panels = layout['configById']
    shown = {path['value'] for panel in panels.values() for path in panel.get('paths', [])}
    assert shown == {f'{topic}.{field}' for topic, field in FIELDS.items()}

    placed = []
    todo = [layout['layout']]
    while todo:
        node = todo.pop()
        if isinstance(node, str):
            placed.append(node)
        else:
            todo += [node['first'], node['second']]
    assert sorted(placed) == sorted(panels)
