"""Forty lab files, written before the importer was begun."""

import json

import numpy as np
from numpy import round as q
from recording.labs.bench import Made, lab_file, muscle, run, table, text


@lab_file('messprotokoll.csv')
def german() -> Made:
    """German: semicolons, decimal commas, Windows-1252, a protocol of six lines above the headings."""
    m = muscle()
    i, T, x = q(m['i'], 3), q(m['T'], 2), q(1e3 * m['x'], 3)
    lines = ['Messprotokoll', 'Prüfer: J. Müller', 'Datum: 12.03.2025', 'Probe: Nylon 6,6, 4-fädig', 'Last: 150 g', '']
    lines += [
        'Zeit [s];Strom [A];Temp. [°C];Weg [mm]',
        *table([m['t'], i, T, x], ['.1f', '.3f', '.2f', '.3f'], ';', True),
    ]
    return text(lines, 'cp1252', '\r\n'), [run(m['t'], current=i, temperature=T, displacement=1e-3 * x)]


@lab_file('aufheizen_03.csv')
def german_units_below() -> Made:
    """Names in one row, units in the next, a byte order mark, current in mA, time in ms."""
    m = muscle(dt=0.1)
    i, T, R = q(1e3 * m['i'], 1), q(m['T'], 1), q(m['R'], 3)
    lines = ['Zeit;Heizstrom;Drahttemperatur;Widerstand', 'ms;mA;°C;Ohm']
    lines += table([1e3 * m['t'], i, T, R], ['.0f', '.1f', '.1f', '.3f'], ';', True)
    return b'\xef\xbb\xbf' + text(lines, newline='\r\n'), [run(m['t'], current=1e-3 * i, temperature=T, resistance=R)]


@lab_file('Versuch 7 Uhrzeit.txt')
def clock_with_comma() -> Made:
    """The time of day with a decimal comma in it, tabs, Greek and a slash before the unit."""
    m = muscle(dt=0.25)
    seconds = 14 * 3600 + 3 * 60 + 52.5 + m['t']
    clock = [f'{int(s // 3600):02d}:{int(s % 3600 // 60):02d}:{s % 60:06.3f}'.replace('.', ',') for s in seconds]
    T, x, i = q(m['T'], 1), q(1e3 * m['x'], 2), q(m['i'], 2)
    lines = ['Uhrzeit\tϑ/°C\tΔl/mm\tI/A', *table([clock, T, -x, i], ['', '.1f', '.2f', '.2f'], '\t', True)]
    return text(lines, 'utf-8', '\r\n'), [run(m['t'], temperature=T, displacement=1e-3 * x, current=i)]


@lab_file('datum_uhrzeit.csv')
def date_and_clock() -> Made:
    """Date and clock in two columns, over midnight; whole seconds."""
    m = muscle(n=40, dt=1.0)
    seconds = 24 * 3600 - 15 + m['t']
    date = ['23.11.2025' if s < 86400 else '24.11.2025' for s in seconds]
    clock = [f'{int(s // 3600) % 24:02d}:{int(s % 3600 // 60):02d}:{int(s % 60):02d}' for s in seconds]
    T, p = q(m['T'], 1), q(m['p'], 3)
    lines = [
        'Datum;Uhrzeit;Temperatur in °C;Leistung in W',
        *table([date, clock, T, p], ['', '', '.1f', '.3f'], ';', True),
    ]
    return text(lines, 'latin-1'), [run(m['t'], temperature=T, power=p)]


@lab_file('210401_0001.CSV')
def japanese_logger() -> Made:
    """Japanese data logger, Shift-JIS: a table of its channels above the data, padded signs, its own units row."""
    m = muscle(dt=0.5)
    T, v, x = q(m['T'], 1), q(m['v'], 3), q(1e3 * m['x'], 3)
    stamp = [f'2025/04/01 10:15:{int(s):02d}' for s in m['t']]
    ms = [f'{500 * (k % 2):d}' for k in range(len(m['t']))]
    lines = ['ﾍﾞﾝﾀﾞ,ログ株式会社', 'ﾓﾃﾞﾙ,LR-800', 'ｻﾝﾌﾟﾘﾝｸﾞ間隔,500ms', 'ｱﾝﾌﾟ設定', 'CH,信号名,入力,ﾚﾝｼﾞ,単位']
    lines += ['CH1,糸温度,TEMP,TC_K,degC', 'CH2,印加電圧,DC,20V,V', 'CH3,変位,DC,10V,mm', 'ﾃﾞｰﾀ']
    lines += ['番号,日付 時間,ms,CH1,CH2,CH3', 'NO.,Time,ms,degC,V,mm']
    number = [str(k + 1) for k in range(len(ms))]
    lines += table([number, stamp, ms, T, v, x], ['', '', '', '+8.1f', '+8.3f', '+8.3f'])
    return text(lines, 'cp932', '\r\n'), [run(m['t'], temperature=T, voltage=v, displacement=1e-3 * x)]


@lab_file('人工筋肉_実験2.csv')
def japanese_plain() -> Made:
    """Japanese in UTF-8 with full-width brackets and units."""
    m = muscle()
    i, T, x, load = q(m['i'], 3), q(m['T'], 1), q(1e3 * m['x'], 3), np.full(30, 1.47)
    lines = ['時間（秒）,電流（Ａ）,温度（℃）,変位（ｍｍ）,荷重（Ｎ）']
    lines += table([m['t'], i, T, x, load], ['.2f', '.3f', '.1f', '.3f', '.2f'])
    return text(lines, 'utf-8-sig'), [run(m['t'], current=i, temperature=T, displacement=1e-3 * x, load=load)]


@lab_file('kinniku.tsv')
def japanese_sjis_tabs() -> Made:
    """Japanese, Shift-JIS, tabs, elapsed time as 0:00:00.5, resistance and room."""
    m = muscle()
    R, T, amb = q(m['R'], 2), q(m['T'], 2), q(m['amb'], 1)
    clock = [f'0:00:{s:04.1f}' for s in m['t']]
    lines = ['経過時間\t抵抗[Ω]\t筋肉温度[℃]\t室温[℃]', *table([clock, R, T, amb], ['', '.2f', '.2f', '.1f'], '\t')]
    return text(lines, 'cp932', '\r\n'), [run(m['t'], resistance=R, temperature=T, ambient=amb)]


def _lvm(separator: str, decimal: str, columns: str) -> list[str]:
    return [
        'LabVIEW Measurement\t',
        'Writer_Version\t2',
        'Reader_Version\t2',
        f'Separator\t{separator}',
        f'Decimal_Separator\t{decimal}',
        'Multi_Headings\tNo',
        f'X_Columns\t{columns}',
        'Time_Pref\tAbsolute',
        'Operator\tlab',
        'Date\t2025/03/12',
        'Time\t14:20:11.7390022277832031250',
        '***End_of_Header***\t',
        '\t',
    ]


@lab_file('test_12.lvm')
def labview_one_x() -> Made:
    """LabVIEW measurement file: two headers, one X column, a comment column that is empty."""
    m = muscle(dt=0.2)
    T, i, F = q(m['T'], 4), q(m['i'], 4), q(m['F'], 4)
    lines = [
        *_lvm('Tab', '.', 'One'),
        'Channels\t3\t\t\t',
        'Samples\t30\t30\t30\t',
        'Date\t2025/03/12\t2025/03/12\t2025/03/12\t',
    ]
    lines += ['Time\t14:20:11.73\t14:20:11.73\t14:20:11.73\t', 'Y_Unit_Label\tDeg C\tAmps\tNewtons\t']
    lines += [
        'X_Dimension\tTime\tTime\tTime\t',
        'X0\t0.0\t0.0\t0.0\t',
        'Delta_X\t0.2\t0.2\t0.2\t',
        '***End_of_Header***\t\t\t\t',
    ]
    lines += ['X_Value\tThermocouple\tCurrent\tLoad Cell\tComment']
    lines += [row + '\t' for row in table([m['t'], T, i, F], ['.6f'] * 4, '\t')]
    return text(lines, newline='\r\n'), [run(m['t'], temperature=T, current=i, force=F)]


@lab_file('Messung_neu.lvm')
def labview_many_x() -> Made:
    """LabVIEW with an X column for each channel, at two rates, and decimal commas."""
    m = muscle(dt=0.2)
    T, x = q(m['T'], 3), q(1e3 * m['x'], 4)
    lines = [*_lvm('Tab', ',', 'Multi'), 'Channels\t2\t\t', 'Samples\t15\t\t30', 'Y_Unit_Label\t°C\t\tmm']
    lines += [
        'X0\t0,0\t\t0,0',
        'Delta_X\t0,4\t\t0,2',
        '***End_of_Header***\t\t\t',
        'X_Value\tTemperatur\tX_Value\tHub\tKommentar',
    ]
    for k in range(30):
        slow = f'{m["t"][2 * k]:.3f}\t{T[2 * k]:.3f}' if k < 15 else '\t'
        lines.append(f'{slow}\t{m["t"][k]:.3f}\t{x[k]:.4f}\t'.replace('.', ','))
    return text(lines, 'cp1252', '\r\n'), [run(m['t'], temperature=(float(T[0]), float(T[28])), displacement=1e-3 * x)]


@lab_file('spreadsheet_out.txt', missing=('head',))
def labview_no_headings() -> Made:
    """LabVIEW's "Write To Spreadsheet File": numbers and tabs, no word of what they are."""
    m = muscle()
    lines = table([m['t'], m['T'], m['i'], 1e3 * m['x']], ['.6f'] * 4, '\t')
    return text(lines, newline='\r\n'), []


@lab_file('serial_putty.log')
def arduino_pairs() -> Made:
    """An Arduino that prints name:value pairs, caught by a terminal, with its greeting and a torn first line."""
    m = muscle(dt=0.1)
    T, i, x = q(m['T'], 2), q(1e3 * m['i'], 0), q(1e3 * m['x'], 2)
    lines = ['=~=~=~=~=~=~= PuTTY log 2025.03.12 14:20:11 =~=~=~=~=~=~=', '4, stroke_mm:0.00', 'TCP rig v1.3', 'Ready.']
    lines += [
        f't_ms:{1e3 * t:.0f}, temp_C:{a:.2f}, current_mA:{b:.0f}, stroke_mm:{c:.2f}'
        for t, a, b, c in zip(m['t'] + 2.4, T, i, x, strict=True)
    ]
    return text(lines, newline='\r\n'), [run(m['t'], temperature=T, current=1e-3 * i, displacement=1e-3 * x)]


@lab_file('monitor.txt')
def arduino_monitor() -> Made:
    """Arduino's serial monitor with its own stamps, and a heading that the sketch printed."""
    m = muscle(dt=0.1)
    T, v, R = q(m['T'], 2), q(m['v'], 2), q(m['R'], 2)
    stamp = [f'14:20:{11 + t:06.3f} -> ' for t in m['t']]
    lines = ['14:20:10.201 -> Booting', '14:20:10.900 -> millis,Temp(C),Voltage(V),Resistance(ohm)']
    data = table([1e3 * m['t'] + 812, T, v, R], ['.0f', '.2f', '.2f', '.2f'])
    lines += [a + b for a, b in zip(stamp, data, strict=True)]
    return text(lines), [run(m['t'], temperature=T, voltage=v, resistance=R)]


@lab_file('plotter.txt', missing=('time',))
def arduino_plotter() -> Made:
    """For the serial plotter: no time at all, and nothing says how often."""
    m = muscle()
    lines = [f'Temp_C:{a:.2f}\tCurrent_A:{b:.2f}' for a, b in zip(m['T'], m['i'], strict=True)]
    return text(lines), []


@lab_file('F0003CH1.CSV')
def tektronix() -> Made:
    """Tektronix: what the scope was set to stands left of the samples, in the same rows."""
    m = muscle(n=30, dt=0.04)
    v = q(m['v'], 3)
    left = [
        'Record Length,3.000000e+01,',
        'Sample Interval,4.000000e-02,',
        'Trigger Point,6.000000000000e+00,',
        ',,',
        ',,',
        ',,',
    ]
    left += ['Source,CH1,', 'Vertical Units,V,', 'Vertical Scale,5.000000e-01,', 'Vertical Offset,0.000000e+00,']
    left += [
        'Horizontal Units,s,',
        'Horizontal Scale,2.500000e-01,',
        'Pt Fmt,Y,',
        'Yzero,0.000000e+00,',
        'Probe Atten,1.000000e+00,',
    ]
    left += ['Model Number,TDS2024B,', 'Serial Number,C000000,', 'Firmware Version,FV:v22.11,'] + [',,'] * 12
    data = table([m['t'] - 0.24, v], ['018.12f', '10.5f'])
    return text([f'{a},{b},' for a, b in zip(left, data, strict=True)], newline='\r\n'), [run(m['t'], voltage=v)]


@lab_file('NewFile1.csv')
def rigol() -> Made:
    """Rigol: a sequence number, and start and increment in the second row."""
    m = muscle(dt=0.02)
    v = q(m['v'], 2)
    lines = ['X,CH1,Start,Increment,', 'Sequence,Volt,-1.200000e-01,2.000000e-02']
    lines += [f'{k},{a:.2e},,' for k, a in enumerate(v)]
    shown = np.array([float(f'{a:.2e}') for a in v])
    return text(lines, newline='\r\n'), [run(m['t'], voltage=shown)]


@lab_file('SDS00012.csv')
def siglent() -> Made:
    """Siglent: five lines of settings, then Second,Volt."""
    m = muscle(dt=0.01)
    v = q(m['v'], 4)
    lines = ['Record Length,Analog:30', 'Sample Rate,100.0', 'Vertical Scale,CH1: 0.50', 'Vertical Offset,CH1:0.00000']
    lines += ['Horizontal Scale, 0.050000000', 'Second,Volt', *table([m['t'] - 0.15, v], ['.11f', '.5f'])]
    return text(lines, newline='\r\n'), [run(m['t'], voltage=v)]


@lab_file('scope_two.csv', missing=('V',))
def scope_two_volts() -> Made:
    """A scope with two channels in volts: one is a shunt, one a sensor, and nothing says which."""
    m = muscle(dt=0.02)
    lines = ['Time,CH1,CH2', '(s),(V),(V)', *table([m['t'], 0.1 * m['i'], 0.01 * m['T']], ['.4f', '.5f', '.5f'])]
    return text(lines), []


@lab_file('trial4_table.csv')
def matlab_writetable() -> Made:
    """MATLAB's writetable: names that are valid in MATLAB, full precision."""
    m = muscle(dt=0.1)
    lines = ['time_s,temp_degC,current_A,displacement_mm,force_N']
    lines += table([m['t'], m['T'], m['i'], 1e3 * m['x'], m['F']], ['.15g'] * 5)
    return text(lines, newline='\r\n'), [
        run(m['t'], temperature=m['T'], current=m['i'], displacement=m['x'], force=m['F'])
    ]


@lab_file('timetable.csv')
def matlab_timetable() -> Made:
    """MATLAB's writetimetable: durations as "0.5 sec", and names with mangled brackets."""
    m = muscle()
    T, x = q(m['T'], 4), q(1e3 * m['x'], 4)
    time = [f'{t:g} sec' for t in m['t']]
    lines = ['Time,Temperature__C_,Stroke_mm_', *table([time, T, x], ['', '.4f', '.4f'])]
    return text(lines), [run(m['t'], temperature=T, displacement=1e-3 * x)]


@lab_file('defbuffer1.csv')
def keithley() -> Made:
    """Keithley multimeter: a buffer of readings; unit, date, time and fractional seconds in columns of their own."""
    m = muscle(dt=0.25)
    R = q(m['R'], 6)
    lines = [
        'DMM6500 Buffer,defbuffer1',
        'Index,Reading,Unit,Range Digits,Math,Limit1 High,Date,Time,Fractional Seconds',
    ]
    for k, (t, r) in enumerate(zip(m['t'], R, strict=True)):
        lines.append(f'{k + 1},{r:.6E},Ohm,6,,F,03/12/2025,14:20:{11 + int(t):02d},{t % 1:.6f}')
    return text(lines), [run(m['t'], resistance=R)]


@lab_file('bench_vue.csv')
def keysight() -> Made:
    """A 34970 data logger: UTF-16, a report above, a channel number in each heading, stamps with colons."""
    m = muscle(dt=1.0)
    T, amb = q(m['T'], 3), q(m['amb'], 3)
    lines = [
        'Name:,tcp run 3',
        'Acquisition Date:,3/12/2025 2:20:11 PM',
        'Owner:,lab',
        'Comments:,"150 g, new coil"',
        '',
    ]
    lines += [
        'Total Channels:,2',
        'Channel,Name,Function,Range',
        '101,Muscle temp,Temp (Type K),C',
        '102,Ambient,Temp (Type K),C',
        '',
    ]
    lines += ['Scan,Time,101 Muscle temp (C),102 Ambient (C)']
    lines += [
        f'{k + 1},3/12/2025 14:20:{11 + k:02d}:000,{a:.3f},{b:.3f}' for k, (a, b) in enumerate(zip(T, amb, strict=True))
    ]
    return b'\xff\xfe' + text(lines, 'utf-16-le', '\r\n'), [run(m['t'], temperature=T, ambient=amb)]


@lab_file('picolog.csv')
def picolog() -> Made:
    """A thermocouple logger: the column of times has no heading."""
    m = muscle(dt=1.0)
    T, amb = q(m['T'], 2), q(m['amb'], 2)
    clock = [f'00:00:{int(t):02d}' for t in m['t']]
    lines = [',Coil Ave. (C),Room Ave. (C)', *table([clock, T, amb], ['', '.2f', '.2f'])]
    return text(lines, newline='\r\n'), [run(m['t'], temperature=T, ambient=amb)]


@lab_file('Specimen_RawData_1.csv')
def instron() -> Made:
    """A tensile tester: everything quoted, units in a row of brackets, extension is positive when longer."""
    m = muscle(dt=0.1)
    x, F = q(1e3 * m['x'], 5), q(m['F'], 5)
    lines = [
        '"Specimen label","nylon 3"',
        '"Length","150.00","mm"',
        '',
        '"Time","Extension","Load"',
        '"(s)","(mm)","(N)"',
    ]
    lines += [f'"{t:.5f}","{a:.5f}","{b:.5f}"' for t, a, b in zip(m['t'], -x, F, strict=True)]
    return text(lines, newline='\r\n'), [run(m['t'], displacement=1e-3 * x, force=F)]


@lab_file('Probe 5.TRA')
def zwick() -> Made:
    """A German tensile tester: quotes, semicolons, decimal commas; a grip distance above; held at one length."""
    m = muscle(dt=0.2)
    F, T = q(m['F'], 4), q(m['T'], 1)
    lines = [
        '"Probenbezeichnung";"Muskel 5"',
        '"Einspannlänge";"150,0";"mm"',
        '"Prüfzeit";"Standardkraft";"Temperatur"',
        '"s";"N";"°C"',
    ]
    lines += table([m['t'], F, T], ['.3f', '.4f', '.1f'], ';', True)
    return text(lines, 'cp1252', '\r\n'), [run(m['t'], force=F, temperature=T)]


@lab_file('laser_overrange.csv')
def laser() -> Made:
    """A laser that goes out of range and a thermocouple that opens: OL, -FFFFFFF, ---- and blanks among numbers."""
    m = muscle()
    T, x = q(m['T'], 1), q(1e3 * m['x'], 3)
    a, b = [f'{v:.1f}' for v in T], [f'{v:+.3f}' for v in x]
    a[4], a[9], b[12], b[13], b[20] = 'OPEN', '----', '-FFFFFFF', '-FFFFFFF', ''
    lines = ['t(s),TC1(degC),laser(mm)', *table([m['t'], a, b], ['.1f', '', ''])]
    return text(lines), [run(m['t'], temperature=T, displacement=1e-3 * x)]


@lab_file('influx_export.csv')
def iso_zone() -> Made:
    """ISO stamps with a zone, names with dots, power in milliwatts."""
    m = muscle()
    p, T = q(1e3 * m['p'], 1), q(m['T'], 3)
    stamp = [f'2025-03-12T14:20:{11 + t:06.3f}+01:00' for t in m['t']]
    lines = ['time,muscle.power_mW,muscle.temperature_C', *table([stamp, p, T], ['', '.1f', '.3f'])]
    return text(lines), [run(m['t'], power=1e-3 * p, temperature=T)]


@lab_file('log_20250312.csv')
def python_epoch() -> Made:
    """A Python script's log: time.time(), pandas' nameless index, nan where a sensor was slower."""
    m = muscle(dt=0.5)
    T, i = q(m['T'], 3), q(m['i'], 4)
    a = [f'{v:.3f}' if k % 2 == 0 else 'nan' for k, v in enumerate(T)]
    index = [str(k) for k in range(30)]
    lines = [
        ',timestamp,muscle_temp,amb_temp,current',
        *table([index, 1741789211.25 + m['t'], a, q(m['amb'], 1), i], ['', '.4f', '', '.1f', '.4f']),
    ]
    return text(lines), [run(m['t'], temperature=(float(T[0]), float(T[28])), ambient=q(m['amb'], 1), current=i)]


@lab_file('savetxt.dat')
def numpy_savetxt() -> Made:
    """numpy.savetxt: a comment sign before the headings, spaces between columns, kelvin, metres."""
    m = muscle(dt=0.1)
    T, x = q(m['T'] + 273.15, 3), q(m['x'], 7)
    lines = ['# rig 2, coil 7', '# t[s] I[A] T[K] x[m]']
    lines += table([m['t'], m['i'], T, x], ['.18e'] * 4, ' ')
    return text(lines), [run(m['t'], current=m['i'], temperature=T - 273.15, displacement=x)]


@lab_file('cycles.dat')
def gnuplot_blocks() -> Made:
    """For gnuplot: three runs, each a block of its own with two blank lines between."""
    lines, runs = ['# time_s  power_W  temp_C'], []
    for k in range(3):
        m = muscle(n=20, seed=k + 1, current=0.2 + 0.02 * k)
        p, T = q(m['p'], 3), q(m['T'], 2)
        lines += [*table([m['t'], p, T], ['7.2f', '7.3f', '7.2f'], '  '), *(['', ''] if k < 2 else [])]
        runs.append(run(m['t'], power=p, temperature=T))
    return text(lines), runs


@lab_file('all_trials.csv')
def trial_column() -> Made:
    """All trials in one table: a column says which; the time begins anew with each."""
    lines, runs = ['trial,time (s),force (N),temperature (C)'], []
    for k in range(4):
        m = muscle(n=15, seed=k + 1)
        F, T = q(m['F'], 3), q(m['T'], 2)
        lines += [f'{k + 1},{row}' for row in table([m['t'], F, T], ['.1f', '.3f', '.2f'])]
        runs.append(run(m['t'], force=F, temperature=T))
    return text(lines), runs


@lab_file('side_by_side.csv')
def side_by_side() -> Made:
    """Three runs side by side as pasted into a sheet: their names above, an empty column between, unequal ends."""
    groups, runs = [], []
    for k in range(3):
        m = muscle(n=20 - 4 * k, seed=k + 1)
        T, x = q(m['T'], 1), q(1e3 * m['x'], 2)
        groups.append(table([m['t'], T, x], ['.1f', '.1f', '.2f']))
        runs.append(run(m['t'], temperature=T, displacement=1e-3 * x))
    lines = ['100 g,,,,200 g,,,,300 g,,', ',,'.join(['Time (s),Temp (°C),Stroke (mm)'] * 3)]
    lines += [',,'.join(g[k] if k < len(g) else ',,' for g in groups) for k in range(20)]
    return text(lines, 'utf-8-sig', '\r\n'), runs


@lab_file('fil_nylon_essai.csv')
def french() -> Made:
    """French, Latin-1: Temps, Intensité, Déplacement, Effort; nothing but a comma for the point."""
    m = muscle()
    i, T, x, F = q(m['i'], 3), q(m['T'], 1), q(1e3 * m['x'], 3), q(m['F'], 3)
    lines = ['Temps (s);Intensité (A);Température (°C);Déplacement (mm);Effort (N)']
    lines += table([m['t'], i, T, x, F], ['.2f', '.3f', '.1f', '.3f', '.3f'], ';', True)
    return text(lines, 'latin-1', '\r\n'), [run(m['t'], current=i, temperature=T, displacement=1e-3 * x, force=F)]


@lab_file('datalog_us.csv')
def imperial() -> Made:
    """From the United States: AM and PM, degrees Fahrenheit, inches, pounds."""
    m = muscle(dt=1.0)
    T, x, F = q(1.8 * m['T'] + 32, 1), q(m['x'] / 0.0254, 4), q(m['F'] / 4.4482216152605, 3)
    stamp = [f'3/12/2025 11:59:{45 + k} AM' if k < 15 else f'3/12/2025 12:00:{k - 15:02d} PM' for k in range(30)]
    lines = ['Timestamp,Temp (F),Stroke (in),Force (lbf)', *table([stamp, T, x, F], ['', '.1f', '.4f', '.3f'])]
    return text(lines), [run(m['t'], temperature=(T - 32) / 1.8, displacement=x * 0.0254, force=F * 4.4482216152605)]


@lab_file('unicode_text.txt')
def excel_unicode() -> Made:
    """Excel's "Unicode Text": UTF-16 with tabs, quoted headings with line breaks in them."""
    m = muscle()
    i, R = q(1e3 * m['i'], 0), q(1e3 * m['R'], 0)
    lines = ['"Time\n(s)"\t"Current\n(mA)"\t"Resistance\n(mΩ)"', *table([m['t'], i, R], ['.1f', '.0f', '.0f'], '\t')]
    return b'\xff\xfe' + '\r\n'.join(lines).encode('utf-16-le'), [run(m['t'], current=1e-3 * i, resistance=1e-3 * R)]


@lab_file('with_summary.csv')
def summary_below() -> Made:
    """Delimiters at the ends of lines, thousands separated in quotes, averages and a signature below the data."""
    m = muscle(dt=0.1)
    t, T, p = 1e3 * m['t'], q(m['T'], 2), q(1e3 * m['p'], 1)
    lines = ['Elapsed (ms),Coil T (°C),Heater power (mW),']
    lines += [f'"{a:,.0f}",{b:.2f},{c:.1f},' for a, b, c in zip(t, T, p, strict=True)]
    lines += ['', f'Average,{T.mean():.2f},{p.mean():.1f},', f'Max,{T.max():.2f},{p.max():.1f},', 'checked: KT,,,']
    return text(lines), [run(m['t'], temperature=T, power=1e-3 * p)]


@lab_file('溫度測試.csv')
def chinese() -> Made:
    """Chinese, GB18030: time, temperature, displacement, pulling force in grams."""
    m = muscle()
    T, x, F = q(m['T'], 1), q(1e3 * m['x'], 2), q(m['F'] / 9.80665e-3, 1)
    lines = ['时间(s),温度(℃),位移(mm),拉力(g)', *table([m['t'], T, x, F], ['.1f', '.1f', '.2f', '.1f'])]
    return text(lines, 'gb18030', '\r\n'), [run(m['t'], temperature=T, displacement=1e-3 * x, force=F * 9.80665e-3)]


@lab_file('export_sep.csv')
def excel_sep() -> Made:
    """A first line "sep=;" for Excel, and points for decimals all the same."""
    m = muscle()
    T, v, i = q(m['T'], 1), q(m['v'], 3), q(m['i'], 3)
    lines = [
        'sep=;',
        'Time;Voltage;Current;Temperature',
        '[s];[V];[A];[°C]',
        *table([m['t'], v, i, T], ['.1f', '.3f', '.3f', '.1f'], ';'),
    ]
    return text(lines, 'utf-8', '\r\n'), [run(m['t'], voltage=v, current=i, temperature=T)]


@lab_file('plotjuggler.csv')
def plotjuggler() -> Made:
    """PlotJuggler's table of ROS topics: each has blanks where another spoke; the names are topics."""
    m = muscle(dt=0.1)
    T, x, i = q(m['T'], 4), q(m['x'], 8), q(m['i'], 4)
    lines = ['__time,/current/data,/displacement/data,/temperature/temperature']
    for k, t in enumerate(m['t'] + 1741789211.0):
        lines += [f'{t:.6f},{i[k]},{x[k]:.8f},', f'{t + 0.01:.6f},,,{T[k]}']
    shown = run(m['t'], temperature=T, displacement=x, current=i)
    return text(lines), [type(shown)(shown.duration + 0.01, 60, shown.channels)]


@lab_file('jsonl.log')
def json_lines() -> Made:
    """One JSON object a line, from a web socket."""
    m = muscle(dt=0.2)
    T, i = q(m['T'], 2), q(m['i'], 3)
    lines = [
        json.dumps({'t': round(float(t), 3), 'T_muscle_C': float(a), 'I_A': float(b)})
        for t, a, b in zip(m['t'], T, i, strict=True)
    ]
    return text(lines), [run(m['t'], temperature=T, current=i)]


@lab_file('restarts.csv')
def restarted() -> Made:
    """A logger that was restarted twice: the headings come again in the middle, and the time from 0."""
    lines, runs = [], []
    for k in range(3):
        m = muscle(n=18, dt=0.5, seed=k + 1)
        T, x = q(m['T'], 2), q(1e3 * m['x'], 3)
        lines += ['Time [s],T [C],x [mm]', *table([m['t'], T, x], ['.2f', '.2f', '.3f'])]
        runs.append(run(m['t'], temperature=T, displacement=1e-3 * x))
    return text(lines), runs
