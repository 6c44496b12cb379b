"""Further lab files: text of other kinds, and the binary ones (spreadsheets, MATLAB, Parquet)."""

import io
from datetime import datetime, timedelta

import numpy as np
from numpy import round as q
from recording.labs.bench import Made, lab_file, muscle, run, table, text

NOON = datetime(2025, 3, 12, 12, 0, 0)


@lab_file('data_minutes.csv')
def minutes() -> Made:
    """Time in minutes after a slash; power and room with units in words."""
    m = muscle(dt=6.0)
    p, T, amb = q(m['p'], 3), q(m['T'], 1), q(m['amb'], 1)
    lines = ['t/min,P/Watt,T/deg C,T_room/deg C', *table([m['t'] / 60, p, T, amb], ['.3f', '.3f', '.1f', '.1f'])]
    return text(lines), [run(m['t'], power=p, temperature=T, ambient=amb)]


@lab_file('length_not_stroke.csv')
def length() -> Made:
    """The muscle's length, not its stroke: contraction is what it becomes shorter by."""
    m = muscle()
    L, T = q(150 - 1e3 * m['x'], 3), q(m['T'], 1)
    lines = ['Zeit in s;Länge in mm;Temperatur in °C', *table([m['t'], L, T], ['.1f', '.3f', '.1f'], ';', True)]
    return text(lines, 'cp1252'), [run(m['t'], displacement=1e-3 * (L[0] - L), temperature=T)]


@lab_file('rate_above.csv')
def rate_in_preamble() -> Made:
    """No time: the rate stands above the headings."""
    m = muscle(dt=0.05)
    T, F = q(m['T'], 2), q(1e3 * m['F'], 1)
    lines = ['Operator: kt', 'Sample rate: 20 Hz', '', 'Temperature (°C),Force (mN)', *table([T, F], ['.2f', '.1f'])]
    return text(lines), [run(m['t'], temperature=T, force=1e-3 * F)]


@lab_file('interval_above.txt')
def interval_in_preamble() -> Made:
    """No time, German: "Abtastintervall: 100 ms" above."""
    m = muscle(dt=0.1)
    i, R = q(m['i'], 3), q(m['R'], 2)
    lines = [
        'Gerät: 2700',
        'Abtastintervall: 100 ms',
        'Strom [A]\tWiderstand [Ohm]',
        *table([i, R], ['.3f', '.2f'], '\t', True),
    ]
    return text(lines, 'cp1252', '\r\n'), [run(m['t'], current=i, resistance=R)]


@lab_file('old_mac.csv')
def carriage_returns() -> Made:
    """Carriage returns alone end the lines, as an old Macintosh wrote them; MacRoman-free, plain names."""
    m = muscle()
    T, i = q(m['T'], 1), q(m['i'], 2)
    lines = ['Time (sec),Temperature (deg. C),Current (Amp)', *table([m['t'], T, i], ['.1f', '.1f', '.2f'])]
    return text(lines, 'ascii', '\r'), [run(m['t'], temperature=T, current=i)]


@lab_file('torn.csv')
def torn() -> Made:
    """Power failed: the last line is torn and zero bytes follow."""
    m = muscle()
    T, x = q(m['T'], 2), q(1e3 * m['x'], 3)
    lines = ['time_s,T_C,x_mm', *table([m['t'], T, x], ['.1f', '.2f', '.3f'])]
    return text(lines) + b'15.0,24' + bytes(512), [run(m['t'], temperature=T, displacement=1e-3 * x)]


@lab_file('set_and_measured.csv')
def set_and_measured() -> Made:
    """A supply's log: what was set and what was measured; the second counts, the first is a command."""
    m = muscle()
    i, T = q(m['i'] * 1.01, 4), q(m['T'], 1)
    lines = ['Time (s),I_set (A),I_meas (A),T (°C)', *table([m['t'], m['i'], i, T], ['.1f', '.3f', '.4f', '.1f'])]
    return text(lines), [run(m['t'], current=i, current_command=m['i'], temperature=T)]


@lab_file('two_thermocouples.csv')
def two_thermocouples() -> Made:
    """Two temperatures, one of the muscle and one of the air, in one style of heading."""
    m = muscle()
    T, amb, p = q(m['T'], 1), q(m['amb'], 1), q(m['p'], 2)
    lines = [
        't [s];T_Luft [°C];T_Muskel [°C];P [W]',
        *table([m['t'], amb, T, p], ['.1f', '.1f', '.1f', '.2f'], ';', True),
    ]
    return text(lines, 'utf-8'), [run(m['t'], temperature=T, ambient=amb, power=p)]


@lab_file('three_thermocouples.csv', missing=('temperature',))
def three_thermocouples() -> Made:
    """Three temperatures that only have numbers: nobody but the lab knows which is the muscle."""
    m = muscle()
    lines = ['Time (s),TC1 (C),TC2 (C),TC3 (C)', *table([m['t'], m['T'], m['T'] + 1, m['amb']], ['.1f'] * 4)]
    return text(lines), []


@lab_file('no_units.csv', missing=('unit',))
def no_units() -> Made:
    """Headings without units, and numbers that would do for two of them."""
    m = muscle(dt=1.0)
    lines = ['time,disp', *table([m['t'], 2 + 1e3 * m['x'] / 4], ['.0f', '.3f'])]
    return text(lines), []


@lab_file('notes.txt', missing=('number',))
def no_data() -> Made:
    """Somebody's notes: no table at all."""
    return text(['12.3. new coil', '150 g hung on it', 'burnt at 0.4 A, see photo']), []


@lab_file('italian.csv')
def italian() -> Made:
    """Italian: Tempo, Corrente, Temperatura, Spostamento, with a title line of its own."""
    m = muscle()
    i, T, x = q(m['i'], 3), q(m['T'], 1), q(1e3 * m['x'], 3)
    lines = ['Prova 3 - muscolo', 'Tempo (s);Corrente (A);Temperatura (°C);Spostamento (mm)']
    lines += table([m['t'], i, T, x], ['.1f', '.3f', '.1f', '.3f'], ';', True)
    return text(lines, 'cp1252'), [run(m['t'], current=i, temperature=T, displacement=1e-3 * x)]


@lab_file('spanish.txt')
def spanish() -> Made:
    """Spanish: Tiempo, Voltaje, Resistencia, Fuerza, columns lined up with spaces."""
    m = muscle()
    v, R, F = q(m['v'], 3), q(m['R'], 3), q(m['F'], 3)
    lines = ['Tiempo(s)   Voltaje(V)   Resistencia(ohm)   Fuerza(N)']
    lines += table([m['t'], v, R, F], ['9.1f', '12.3f', '18.3f', '11.3f'], '')
    return text(lines), [run(m['t'], voltage=v, resistance=R, force=F)]


@lab_file('micro_esp.csv')
def esp_micros() -> Made:
    """An ESP32: micros() that wraps at 2^32, and millidegrees."""
    m = muscle(dt=0.1)
    start = 2**32 - 1_200_000
    micros = (start + np.round(1e6 * m['t']).astype(int)) % 2**32
    T, i = q(m['T'], 1), q(1e3 * m['i'], 0)
    lines = ['micros,temp_degC,I_mA', *table([micros.astype(float), T, i], ['.0f', '.1f', '.0f'])]
    return text(lines), [run(m['t'], temperature=T, current=1e-3 * i)]


@lab_file('own_clocks.csv')
def own_clocks() -> Made:
    """Each channel beside a time of its own, one twice as fast as the other."""
    m = muscle(dt=0.25)
    T, x = q(m['T'], 2), q(1e3 * m['x'], 3)
    lines = ['Time (s),Temperature (°C),Time (s),Displacement (mm)']
    lines += [
        f'{m["t"][k]:.2f},{T[k]:.2f},' + (f'{m["t"][2 * k]:.2f},{x[2 * k]:.3f}' if k < 15 else ',') for k in range(30)
    ]
    shown = run(m['t'], temperature=T, displacement=(1e-3 * x[0], 1e-3 * x[28]))
    return text(lines), [shown]


@lab_file('remarks.csv')
def remarks() -> Made:
    """A column of remarks, with commas in quotes, among the numbers; a state as a word."""
    m = muscle()
    T, i = q(m['T'], 1), q(m['i'], 3)
    state = ['heat' if v else 'idle' for v in m['i']]
    remark = ['"fan on, door open"' if k == 7 else '' for k in range(30)]
    lines = [
        'Time (s),State,Current (A),Temperature (°C),Remark',
        *table([m['t'], state, i, T, remark], ['.1f', '', '.3f', '.1f', '']),
    ]
    return text(lines), [run(m['t'], current=i, temperature=T)]


@lab_file('dead_weight.csv')
def load_column() -> Made:
    """The weight that hangs on it, in grams, in every row; the stroke in micrometres."""
    m = muscle()
    T, x, load = q(m['T'], 1), q(1e6 * m['x'], 0), np.full(30, 150.0)
    lines = ['Time[s],Weight[g],Temp[C],Contraction[um]', *table([m['t'], load, T, x], ['.1f', '.0f', '.1f', '.0f'])]
    return text(lines), [run(m['t'], load=load * 9.80665e-3, temperature=T, displacement=1e-6 * x)]


@lab_file('falling_time.csv', missing=('time', 'row'))
def falling_time() -> Made:
    """The time jumps back by a second in the middle: neither a new run nor one clock."""
    m = muscle()
    t = m['t'].copy()
    t[15:] -= 1.25
    lines = ['Time (s),Temp (C)', *table([t, m['T']], ['.2f', '.2f'])]
    return text(lines), []


@lab_file('Auswertung.xlsx')
def german_sheet() -> Made:
    """Excel, German: notes on the first sheet, the data on the second below a merged title, numbers as numbers."""
    from openpyxl import Workbook

    m = muscle()
    i, T, x = q(m['i'], 3), q(m['T'], 2), q(1e3 * m['x'], 3)
    book = Workbook()
    book.active.title = 'Info'
    book.active.append(['Versuch', 'Kriechen'])
    sheet = book.create_sheet('Messdaten')
    sheet.append(['Muskel 4, 150 g'])
    sheet.merge_cells('A1:D1')
    sheet.append([])
    sheet.append(['Zeit', 'Strom', 'Temperatur', 'Weg'])
    sheet.append(['s', 'A', '°C', 'mm'])
    for row in zip(m['t'], i, T, x, strict=True):
        sheet.append([float(v) for v in row])
    made = io.BytesIO()
    book.save(made)
    return made.getvalue(), [run(m['t'], current=i, temperature=T, displacement=1e-3 * x)]


@lab_file('dates.xlsx')
def sheet_with_dates() -> Made:
    """Excel with real dates in the first column, and two sheets that are two runs."""
    from openpyxl import Workbook

    book, runs = Workbook(), []
    book.remove(book.active)
    for k in range(2):
        m = muscle(n=16, dt=1.0, seed=k + 1)
        p, T = q(m['p'], 3), q(m['T'], 1)
        sheet = book.create_sheet(f'run {k + 1}')
        sheet.append(['Timestamp', 'Power (W)', 'Temp (°C)'])
        for t, a, b in zip(m['t'], p, T, strict=True):
            sheet.append([NOON + timedelta(seconds=float(t)), float(a), float(b)])
        runs.append(run(m['t'], power=p, temperature=T))
    made = io.BytesIO()
    book.save(made)
    return made.getvalue(), runs


def _mat(content: dict[str, object]) -> bytes:
    from scipy.io import savemat

    made = io.BytesIO()
    savemat(made, content)
    return made.getvalue()


@lab_file('run7.mat')
def mat_variables() -> Made:
    """MATLAB: plain variables with units in their names, among a parameter and a text."""
    m = muscle()
    content = {
        'time_s': m['t'],
        'temp_C': m['T'],
        'current_A': m['i'],
        'stroke_mm': 1e3 * m['x'],
        'R0': 7.8,
        'note': 'coil 3',
    }
    return _mat(content), [run(m['t'], temperature=m['T'], current=m['i'], displacement=m['x'])]


@lab_file('trials.mat')
def mat_struct_array() -> Made:
    """MATLAB: a struct array, one element a trial, of unequal lengths."""
    runs, trials = [], []
    for k in range(3):
        m = muscle(n=15 + 5 * k, seed=k + 1)
        trials.append(
            {'t_s': m['t'][:, None], 'T_degC': m['T'][:, None], 'F_N': m['F'][:, None], 'name': f'trial {k + 1}'}
        )
        runs.append(run(m['t'], temperature=m['T'], force=m['F']))
    return _mat({'data': np.array(trials, dtype=object)}), runs


@lab_file('simulink.mat')
def mat_simulink() -> Made:
    """MATLAB: Simulink's "structure with time": time, and signals with labels and values."""
    m = muscle(dt=0.1)
    signals = np.array(
        [
            {'values': m['T'][:, None], 'label': 'Temperature [degC]'},
            {'values': m['v'][:, None], 'label': 'Voltage [V]'},
        ],
        dtype=object,
    )
    return _mat({'ScopeData': {'time': m['t'][:, None], 'signals': signals, 'blockName': 'rig/Scope'}}), [
        run(m['t'], temperature=m['T'], voltage=m['v'])
    ]


@lab_file('frame.parquet')
def parquet() -> Made:
    """Parquet from pandas: stamps as the index."""
    import pandas as pd

    m = muscle(dt=0.2)
    index = pd.DatetimeIndex(pd.to_datetime('2025-03-12') + pd.to_timedelta(m['t'], unit='s'), name='stamp')
    frame = pd.DataFrame(
        {'current (mA)': 1e3 * m['i'], 'temperature (°C)': m['T'], 'displacement (mm)': 1e3 * m['x']}, index=index
    )
    made = io.BytesIO()
    frame.to_parquet(made)
    return made.getvalue(), [run(m['t'], current=m['i'], temperature=m['T'], displacement=m['x'])]


@lab_file('long.parquet')
def parquet_runs() -> Made:
    """Parquet with a column that names the run."""
    import pandas as pd

    frames, runs = [], []
    for name in ('a', 'b'):
        m = muscle(n=20, seed=ord(name))
        frames.append(pd.DataFrame({'run': name, 't_s': m['t'], 'power_W': m['p'], 'temp_C': m['T']}))
        runs.append(run(m['t'], power=m['p'], temperature=m['T']))
    made = io.BytesIO()
    pd.concat(frames, ignore_index=True).to_parquet(made)
    return made.getvalue(), runs


@lab_file('broken.xlsx', missing=('xlsx',))
def broken_sheet() -> Made:
    """A text file that somebody named .xlsx."""
    return text(['time_s,T_C', '0,23', '1,24', '2,25']), []
