# ruff: noqa: B905, C408, E501, E731, E741, RUF005, RUF046, UP031
"""Fifty-six odd lab files, and what a careful person reads in them, by somebody who had not seen the importer.

Kept as its author wrote it, but for where it writes to. Every file comes from one simulated muscle: runs, rows,
durations and values are those of the arrays that were written.
"""

import datetime as dt
import io
import json
import os
import re
import zipfile

import numpy as np

OUT = ''
EXP = {}
NAMES = (
    'Messung_Spule3_14.11.2023.csv',
    'Pruefstand_Muskel_0017.csv',
    '実験2_昇温.csv',
    '230412-130215.CSV',
    'tcp_kajuu_50g.csv',
    'essai_muscle_07.txt',
    '尼龙肌肉_第3组.csv',
    'REC20230911.TXT',
    'tcp_step_250mA.lvm',
    'Aktor_Zyklen.lvm',
    'serial_monitor_tcp.txt',
    'putty_muscle.log',
    'COM5_log3.csv',
    'tek0004ALL.csv',
    'F0003CH1.CSV',
    'scope_12.csv',
    'NewFile3.csv',
    'defbuffer1.csv',
    'KickStart_2450_IVt.csv',
    'Data 17 11_14_2023 10_22_18.csv',
    'trials_TCP_B.mat',
    'run12_v7.mat',
    'data.mat',
    'T_run3.csv',
    'TCP_experiments_Feb.xlsx',
    '2024-02-02 heating test.xlsx',
    'compare_weights.xlsx',
    'Logger_export_0521.xlsx',
    'session_0007.parquet',
    'df_out.csv',
    'tcp_2023-08-30_a.dat',
    'ir_camera_roi1.asc',
    'OUT33.PRN',
    'influx_query.csv',
    'grafana_data_export.csv',
    'night_run.csv',
    'mqtt_muscle.csv',
    'rig.jsonl',
    'long_soak.csv',
    'all_trials.csv',
    'sweep.gp',
    'UT61E_and_TC.csv',
    'export_quoted.csv',
    'ETH_Messreihe.txt',
    'Igor_wave_export',
    'ME421 Lab 6 Team 3.csv',
    'LK-G_kyori.csv',
    'Specimen_RawData_1.csv',
    'pwm_drive_12V.txt',
    'PicoLog6-export.csv',
    'Origin_book1.txt',
    'daq_ai0_ai1.txt',
    'tracker_massA.txt',
    '근육_전원기록.csv',
    'ensayo_12.csv',
    'teraterm_2022-08-02.log',
)


# ------------------------------------------------------------------ the muscle
def step(on, off):
    return lambda t: ((t >= on) & (t < off)).astype(float)


def square(start, period, duty, n):
    def f(t):
        ph = (t - start) / period
        return ((ph >= 0) & (ph < n) & (ph % 1 < duty)).astype(float)

    return f


def stairs(levels, hold):
    return lambda t: np.array(levels + [0.0])[np.clip((t // hold).astype(int), 0, len(levels))]


def sine(start, f, mean=0.5, amp=0.4):
    return lambda t: np.where(t < start, 0, mean + amp * np.sin(2 * np.pi * f * (t - start)))


def sim(
    seed,
    dur,
    d,
    prof,
    I0=0.25,
    R0=40.0,
    Ta=23.0,
    tau=15.0,
    k=27.0,
    alpha=6e-4,
    stroke=0.26,
    F0=1.0,
    jitter=0.0,
    noise=1.0,
    n=None,
):
    """k: K/W, stroke: mm per K (nearly linear, steeper when hot)."""
    g = np.random.default_rng(seed)
    m = np.random.default_rng(9000 + (seed // 10 if seed >= 100 else seed))  # every lab has its own muscle
    k *= m.uniform(0.62, 1.0)
    tau *= m.uniform(0.7, 1.4)
    stroke *= m.uniform(0.45, 1.15)
    if R0 == 40.0 and seed != 49:
        R0 = m.uniform(36, 46)
        k *= 40 / R0
    n = n or int(round(dur / d)) + 1
    t = np.arange(n) * d
    if jitter:
        t = t + np.concatenate([[0], g.uniform(-jitter, jitter, n - 1)])
    u = prof(t) * I0
    sub = 4
    T = np.empty(n)
    x = np.empty(n)
    Tc = Ta
    xc = 0.0
    for i in range(n):
        T[i] = Tc
        x[i] = xc
        h = (t[i + 1] - t[i] if i + 1 < n else d) / sub
        for _ in range(sub):
            P = u[i] ** 2 * R0 * (1 + alpha * (Tc - 25))
            Tc += h / tau * (k * P - (Tc - Ta))
            e = Tc - Ta
            xc += h / 1.2 * (stroke * e * (0.75 + 0.004 * e) - xc)
    R = R0 * (1 + alpha * (T - 25))
    N = lambda s: g.normal(0, s * noise, n)
    S = dict(
        t=t,
        I=u + N(3e-4),
        V=u * R + N(8e-3),
        R=R + N(0.02),
        T=T + N(0.08),
        x=x + N(0.015),
        F=F0 * (1 + 0.01 * np.gradient(x, t)) + N(0.004),
        A=Ta + 0.15 * np.sin(t / 170 + seed) + N(0.03),
        u=u,
        Ttrue=T,
        g=g,
    )
    S['P'] = S['I'] * S['V']
    return S


r = lambda a, nd: np.round(np.asarray(a, float), nd) + 0.0

# ------------------------------------------------------------------ what a careful human reads
K = 273.15
CONV = {
    'A': 1,
    'mA': 1e-3,
    'uA': 1e-6,
    'V': 1,
    'mV': 1e-3,
    'W': 1,
    'mW': 1e-3,
    'ohm': 1,
    'kOhm': 1e3,
    'mOhm': 1e-3,
    'm': 1,
    'cm': 1e-2,
    'mm': 1e-3,
    'um': 1e-6,
    'inch': 0.0254,
    'mil': 2.54e-5,
    'N': 1,
    'mN': 1e-3,
    'gf': 9.80665e-3,
    'kgf': 9.80665,
    'lbf': 4.4482216152605,
    'ozf': 0.27801385095378125,
    'K': 1,
    'degC': lambda a: a + K,
    'degF': lambda a: (a - 32) / 1.8 + K,
}


def expect(name, lab, runs, missing=None, notes=None, **extra):
    """runs: [(t, {channel: (unit, array in file units[, {conv, needs_hint, note}])})]"""
    e = {
        'lab': lab,
        'runs': len(runs),
        'rows': [len(q[0]) for q in runs],
        'duration_s': [round(float(q[0][-1] - q[0][0]), 6) for q in runs],
        'channels': {},
    }
    for c, v in runs[0][1].items():
        o = dict(v[2]) if len(v) > 2 else {}
        cv = o.pop('conv', None) or CONV[v[0]]
        a = np.asarray(v[1], float)
        a = a[np.isfinite(a)]
        s = cv(a) if callable(cv) else a * cv
        g = lambda z: float(f'{z:.9g}')
        e['channels'][c] = {
            'unit_in_file': v[0],
            'first_si': g(s[0]),
            'max_si': g(s.max()),
            'min_si': g(s.min()),
            'last_si': g(s[-1]),
            'valid_rows': len(a),
            **o,
        }
    e['missing'] = missing
    if notes:
        e['notes'] = notes
    e.update(extra)
    assert name not in EXP
    EXP[name] = e


def save(name, text, enc='utf-8', nl='\n'):
    with open(os.path.join(OUT, name), 'wb') as f:
        f.write(text.replace('\n', nl).encode(enc))


def fx(v, nd, dec='.'):
    if not np.isfinite(v):
        return ''
    return f'{v:.{nd}f}'.replace('.', dec)


def table(cols, nds, sep=',', dec='.'):
    return ''.join(sep.join(fx(v, n, dec) for v, n in zip(row, nds)) + '\n' for row in zip(*cols))


def clock(t0, s, f='%H:%M:%S', ms=True):
    q = t0 + dt.timedelta(milliseconds=int(round(s * 1000)))
    return q.strftime(f) + (f'.{q.microsecond // 1000:03d}' if ms else '')


# 1 German Excel
def f01():
    nm = 'Messung_Spule3_14.11.2023.csv'
    S = sim(1, 300, 0.2, step(20, 160))
    t, I, T, x = r(S['t'], 1), r(S['I'] * 1e3, 1), r(S['T'], 2), r(S['x'], 3)
    save(nm, 'Zeit/s;Strom/mA;Temperatur/°C;Weg/mm\n' + table([t, I, T, x], [1, 1, 2, 3], ';', ','), 'cp1252', '\r\n')
    expect(
        nm,
        'German group, DAQ values saved from German Excel (semicolon, decimal comma, cp1252, CRLF)',
        [(t, {'current': ('mA', I), 'temperature': ('degC', T), 'displacement': ('mm', x)})],
    )


# 2 German with thousands points, time in ms, preamble
def f02():
    nm = 'Pruefstand_Muskel_0017.csv'
    S = sim(2, 240, 0.1, square(10, 60, 0.5, 3), I0=0.27)
    t = r(S['t'] * 1e3, 0)
    R_, U, F = r(S['R'], 3), r(S['V'] * 1e3, 1), r(S['F'], 3)
    de = lambda v, n: f'{v:,.{n}f}'.replace(',', '#').replace('.', ',').replace('#', '.')
    h = (
        'Prüfstand;TCP-Antagonist\nPrüfer;M. Weiß\nDatum;03.05.2024\nProbe;PA6,6 verdrillt, Ag-beschichtet\nAnzahl Werte;%s\n\n'
        'Zeit [ms];Spannung [mV];Widerstand [Ω];Kraft [N]\n' % de(len(t), 0)
    )
    save(
        nm,
        h + ''.join(f'{de(a, 0)};{de(b, 1)};{de(c, 3)};{de(d, 3)}\n' for a, b, c, d in zip(t, U, R_, F)),
        'utf-8-sig',
        '\r\n',
    )
    expect(
        nm,
        'German test bench software, preamble, thousands points AND decimal commas, time in ms, UTF-8 BOM',
        [(t / 1e3, {'voltage': ('mV', U), 'resistance': ('ohm', R_), 'load': ('N', F)})],
    )


# 3 Japanese Shift-JIS
def f03():
    nm = '実験2_昇温.csv'
    S = sim(3, 180, 0.1, step(10, 90), Ta=25.5)
    t, I, T, x = r(S['t'], 2), r(S['I'], 4), r(S['T'], 1), r(S['x'], 2)
    save(
        nm,
        '試料名,釣糸人工筋肉No.5\n測定日,2023/06/08\n\n時間[s],電流[A],温度[℃],変位[mm]\n'
        + table([t, I, T, x], [2, 4, 1, 2]),
        'cp932',
        '\r\n',
    )
    expect(
        nm,
        'Japanese student, Excel CSV in Shift-JIS',
        [(t, {'current': ('A', I), 'temperature': ('degC', T), 'displacement': ('mm', x)})],
    )


# 4 Graphtec GL840 (Japanese)
def f04():
    nm = '230412-130215.CSV'
    S = sim(4, 239.8, 0.2, step(15, 120), Ta=22.2)
    t = r(S['t'], 1)
    T, A, V = r(S['T'], 1), r(S['A'], 1), r(S['V'], 3)
    lz = r(S['x'] / 5, 4)
    t0 = dt.datetime(2023, 4, 12, 13, 2, 15)
    h = (
        'メーカ名,GRAPHTEC Corporation\n機種名,GL840-M\nバージョン,Ver1.20\nサンプリング間隔,200ms\nデータ点数,%d\n'
        'データ開始時刻,2023/04/12,13:02:15\nデータ終了時刻,2023/04/12,%s\nトリガ時刻,2023/04/12,13:02:15\nアンプ設定\n'
        'CH,信号名,入力,レンジ,フィルタ,スパン,,,\n'
        'CH1,筋肉表面温度,TEMP,TC_K,Off,200.000000,-100.000000,degC\n'
        'CH2,室温,TEMP,TC_K,Off,200.000000,-100.000000,degC\n'
        'CH3,印加電圧,DC,20V,Off,20.000000,-20.000000,V\n'
        'CH4,レーザ変位,DC,5V,Off,5.000000,-5.000000,V\n'
        'ロジック/パルス,Off\nデータ\n番号,日付 時間,ms,CH1,CH2,CH3,CH4,A12345678910\nNO.,Time,ms,degC,degC,V,V,A12345678910\n'
    ) % (len(t), clock(t0, t[-1], ms=False))
    sg = lambda v, n, w: ('-' if v < 0 else '+') + f'{abs(v):{w}.{n}f}'
    b = ''
    for i in range(len(t)):
        q = t0 + dt.timedelta(seconds=float(t[i]))
        b += f'{i + 1},{q:%Y/%m/%d %H:%M:%S},{int(round(t[i] * 1000)) % 1000},{sg(T[i], 1, 6)},{sg(A[i], 1, 6)},{sg(V[i], 3, 7)},{sg(lz[i], 4, 7)},LLLLLLLLLL\n'
    save(nm, h + b, 'cp932', '\r\n')
    expect(
        nm,
        'Japanese lab, Graphtec GL840 midi logger (channel names only in the amp-settings block, signed padded numbers, ms in own column)',
        [
            (
                t,
                {
                    'temperature': ('degC', T),
                    'ambient': ('degC', A),
                    'voltage': ('V', V),
                    'displacement': ('V', lz, {'conv': 5e-3, 'needs_hint': True}),
                },
            )
        ],
        "CH4 'laser displacement' is a voltage; scale 5 mm per V is written nowhere",
    )


# 5 Japanese UTF-8 full-width units, power and load in gf
def f05():
    nm = 'tcp_kajuu_50g.csv'
    S = sim(5, 200, 0.5, stairs([0, 0.5, 0.75, 1, 0.75, 0.5], 30), F0=0.49, Ta=24)
    t, P, T, F = r(S['t'], 1), r(S['P'] * 1e3, 0), r(S['T'], 2), r(S['F'] / 9.80665e-3, 1)
    save(nm, '経過時間（秒）,電力（mW）,表面温度（℃）,荷重（gf）\n' + table([t, P, T, F], [1, 0, 2, 1]))
    expect(
        nm,
        'Japanese lab, UTF-8 without BOM, full-width brackets, power in mW and load in gf',
        [(t, {'power': ('mW', P), 'temperature': ('degC', T), 'load': ('gf', F)})],
    )


# 6 French
def f06():
    nm = 'essai_muscle_07.txt'
    S = sim(6, 240, 0.1, step(12, 110), F0=1.47, Ta=21.3)
    t, I, T, x, F = r(S['t'], 1), r(S['I'], 3), r(S['T'], 1), r(S['x'], 2), r(S['F'], 3)
    save(
        nm,
        'Essai n° 7\tOpérateur : C. Lefèvre\nDate\t12/02/2024\nLongueur à vide\t118 mm\n\nTemps (s)\tIntensité (A)\tTempérature (°C)\tDéplacement (mm)\tEffort (N)\n'
        + table([t, I, T, x, F], [1, 3, 1, 2, 3], '\t', ','),
        'latin-1',
        '\r\n',
    )
    expect(
        nm,
        'French lab, tab separated, decimal comma, Latin-1',
        [(t, {'current': ('A', I), 'temperature': ('degC', T), 'displacement': ('mm', x), 'load': ('N', F)})],
    )


# 7 Chinese GBK
def f07():
    nm = '尼龙肌肉_第3组.csv'
    S = sim(7, 160, 0.1, step(8, 70), I0=0.28, Ta=19.8)
    t, I, V, T, x = r(S['t'], 1), r(S['I'], 3), r(S['V'], 2), r(S['T'], 1), r(S['x'], 2)
    save(nm, '时间(s),电流(A),电压(V),温度(℃),位移(mm)\n' + table([t, I, V, T, x], [1, 3, 2, 1, 2]), 'gbk', '\r\n')
    expect(
        nm,
        'Chinese lab, Excel CSV in GBK',
        [(t, {'current': ('A', I), 'voltage': ('V', V), 'temperature': ('degC', T), 'displacement': ('mm', x)})],
    )


# 8 Chinese multi-channel temperature recorder
def f08():
    nm = 'REC20230911.TXT'
    S = sim(8, 600, 1.0, square(30, 180, 0.4, 3), Ta=26)
    t, T, A, R_ = S['t'], r(S['T'], 1), r(S['A'], 1), r(S['R'], 2)
    t0 = dt.datetime(2023, 9, 11, 9, 58, 40)
    b = ''.join(
        f'{i + 1}\t{clock(t0, s, "%Y-%m-%d", False)}\t{clock(t0, s, ms=False)}\t{a}\t{c}\t{d}\n'
        for i, (s, a, c, d) in enumerate(zip(t, T, A, R_))
    )
    save(nm, '序号\t日期\t时间\t通道1 温度(℃)\t通道2 室温(℃)\t通道3 电阻(Ω)\n' + b, 'utf-8-sig', '\r\n')
    expect(
        nm,
        'Chinese paperless recorder, serial number + separate date and clock columns, tab separated, BOM',
        [(t, {'temperature': ('degC', T), 'ambient': ('degC', A), 'resistance': ('ohm', R_)})],
        'the drive (current) is not in the file',
    )


# 9 LabVIEW lvm
def f09():
    nm = 'tcp_step_250mA.lvm'
    S = sim(9, 199.9, 0.1, step(10, 100))
    t, I, T, x = r(S['t'], 6), r(S['I'], 6), r(S['T'], 6), r(S['x'], 6)
    n = len(t)
    h = (
        'LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nMulti_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\n'
        'Operator\tlabuser\nDescription\tTCP #4, 250 mA step, 100 g\nDate\t2022/06/17\nTime\t15:42:07.1234567890123\n***End_of_Header***\t\n\t\n'
        f'Channels\t3\t\t\t\nSamples\t{n}\t{n}\t{n}\t\nDate\t2022/06/17\t2022/06/17\t2022/06/17\t\n'
        'Time\t15:42:07.1234567890123\t15:42:07.1234567890123\t15:42:07.1234567890123\t\nY_Unit_Label\tAmps\tDeg C\tmm\t\n'
        'X_Dimension\tTime\tTime\tTime\t\nX0\t0.0000000000000000E+0\t0.0000000000000000E+0\t0.0000000000000000E+0\t\n'
        'Delta_X\t0.100000\t0.100000\t0.100000\t\n***End_of_Header***\t\t\t\t\nX_Value\tCurrent\tThermocouple\tLVDT\tComment\n'
    )
    save(nm, h + table([t, I, T, x], [6] * 4, '\t'), nl='\r\n')
    expect(
        nm,
        'LabVIEW Write To Measurement File, relative time, units in Y_Unit_Label',
        [(t, {'current': ('A', I), 'temperature': ('degC', T), 'displacement': ('mm', x)})],
    )


# 10 LabVIEW lvm, European, no X column, three segments appended
def f10():
    nm = 'Aktor_Zyklen.lvm'
    d = 0.05
    runs = []
    txt = (
        'LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\nMulti_Headings\tYes\nX_Columns\tNo\nTime_Pref\tAbsolute\n'
        'Operator\tSchäfer\nDate\t2021/03/09\nTime\t10:11:12,5\n***End_of_Header***\t\n\t\n'
    )
    for k_, I0 in enumerate((0.20, 0.24, 0.28)):
        S = sim(100 + k_, 60 - d, d, step(3, 28), I0=I0, tau=9)
        n = len(S['t'])
        I, T = r(S['I'], 6), r(S['T'], 6)
        hh = f'10:{11 + 5 * k_}:12,5'
        txt += (
            f'Channels\t2\t\t\nSamples\t{n}\t{n}\t\nDate\t2021/03/09\t2021/03/09\t\nTime\t{hh}\t{hh}\t\nY_Unit_Label\tA\t°C\t\nX_Dimension\tTime\tTime\t\n'
            'X0\t0,0000000000000000E+0\t0,0000000000000000E+0\t\nDelta_X\t0,050000\t0,050000\t\n***End_of_Header***\t\t\t\nX_Value\tStrom\tTemperatur\tComment\n'
        )
        txt += ''.join(f'\t{fx(a, 6, ",")}\t{fx(b, 6, ",")}\n' for a, b in zip(I, T)) + '\n'
        runs.append((r(S['t'], 6), {'current': ('A', I), 'temperature': ('degC', T)}))
    save(nm, txt, 'cp1252', '\r\n')
    expect(
        nm,
        'German LabVIEW, decimal comma, no X column (time only from Delta_X), one header per appended recording',
        runs,
    )


# 11 Arduino serial monitor with timestamps and header
def f11():
    nm = 'serial_monitor_tcp.txt'
    S = sim(11, 240, 0.2, step(10, 120), jitter=0.012, noise=2)
    tm, T, I, x = S['t'], r(S['T'], 2), r(np.maximum(S['I'], 0), 3), r(S['x'], 1)
    t0 = dt.datetime(2024, 1, 9, 14, 3, 22, 123000)
    b = ''.join(f'{clock(t0, s)} -> {a:.2f},{c:.3f},{e:.1f}\n' for s, a, c, e in zip(tm, T, I, x))
    save(
        nm,
        '14:03:20.871 -> MAX31855 init... ok\n14:03:21.402 -> INA219 ok\n14:03:22.010 -> temp_C,current_A,stroke_mm\n'
        + b,
        nl='\r\n',
    )
    expect(
        nm,
        "Arduino serial monitor copied with 'show timestamp', boot messages first",
        [(r(tm, 3), {'temperature': ('degC', T), 'current': ('A', I), 'displacement': ('mm', x)})],
    )


# 12 Arduino key=value
def f12():
    nm = 'putty_muscle.log'
    S = sim(12, 150, 0.25, square(5, 50, 0.5, 3), jitter=0.01, tau=10)
    ms = np.round(S['t'] * 1e3 + 2013).astype(int)
    T, I, D = r(S['T'], 2), r(S['I'] * 1e3, 1), np.where(S['u'] > 0, 204, 0)
    b = ''.join(f't={a} ms  T={c:.2f} C  I={e:.1f} mA  pwm={p}\n' for a, c, e, p in zip(ms, T, I, D))
    save(
        nm,
        '=~=~=~=~=~=~=~=~=~=~=~= PuTTY log 2022.10.04 16:20:51 =~=~=~=~=~=~=~=~=~=~=~=\nSketch tcp_drive v0.3\n' + b,
        nl='\r\n',
    )
    expect(
        nm,
        'Arduino printing key=value pairs into a PuTTY log (millis clock, pwm count alongside)',
        [(ms / 1e3, {'temperature': ('degC', T), 'current': ('mA', I)})],
        notes='pwm is an 8-bit count, not one of the channels',
    )


# 13 Arduino headerless
def f13():
    nm = 'COM5_log3.csv'
    S = sim(13, 120, 0.1, step(5, 60), jitter=0.004, tau=11)
    ms = np.round(S['t'] * 1e3 + 500).astype(int)
    T, I, x = r(S['T'], 2), r(S['I'] * 1e3, 1), r(S['x'], 2)
    save(nm, ''.join(f'{a},{c:.2f},{e:.1f},{p:.2f}\n' for a, c, e, p in zip(ms, T, I, x)))
    h = {'needs_hint': True}
    expect(
        nm,
        'Arduino CSV without any heading',
        [(ms / 1e3, {'temperature': ('degC', T, h), 'current': ('mA', I, h), 'displacement': ('mm', x, h)})],
        'no heading: columns are time in ms, temperature in degC, current in mA, stroke in mm',
    )


# 14 Tektronix DPO
def f14():
    nm = 'tek0004ALL.csv'
    S = sim(14, 99.95, 0.05, step(10, 55), tau=9)
    t = r(S['t'] - 10, 3)
    I, v = r(S['I'], 4), r(S['x'] / 5 + 0.02, 3)
    h = (
        'Model,DPO2024\nFirmware Version,1.52\n\nPoint Format,Y,\nHorizontal Units,S,\nHorizontal Scale,10,\nHorizontal Delay,0,\nSample Interval,0.05,\n'
        f'Record Length,{len(t)},\nGating,0.0% to 100.0%,\nProbe Attenuation,1,10\nVertical Units,A,V\nVertical Offset,0,0\nVertical Scale,0.1,1\nVertical Position,-2,-3\n,,\n,,\nLabel,I_coil,LASER\nTIME,CH1,CH2\n'
    )
    save(nm, h + ''.join(f'{a:.4e},{c:.4f},{e:.3f}\n' for a, c, e in zip(t, I, v)), nl='\r\n')
    expect(
        nm,
        'Tektronix DPO2024, current probe on CH1 (units A), analog laser output on CH2 through a 10x probe (already scaled)',
        [
            (
                t,
                {
                    'current': ('A', I),
                    'displacement': ('V', v, {'conv': lambda a: (a - 0.02) * 5e-3, 'needs_hint': True}),
                },
            )
        ],
        "CH2 'LASER' in V: 5 mm per V, 0.02 V at rest; time starts at -10 s (trigger)",
    )


# 15 Tek TDS old style, one channel with left settings columns
def f15():
    nm = 'F0003CH1.CSV'
    S = sim(15, 49.98, 0.02, step(5, 30), tau=7)
    n = 2500
    t, V = S['t'][:n] - 5, r(np.round(S['V'][:n] / 0.08) * 0.08, 5)
    left = [
        'Record Length,2.500000e+03',
        'Sample Interval,2.000000e-02',
        'Trigger Point,2.500000000000e+02',
        '',
        '',
        '',
        'Source,CH1',
        'Vertical Units,V',
        'Vertical Scale,2.000000e+00',
        'Vertical Offset,0.000000e+00',
        'Horizontal Units,s',
        'Horizontal Scale,5.000000e+00',
        'Pt Fmt,Y',
        'Yzero,0.000000e+00',
        'Probe Atten,1.000000e+01',
        'Model Number,TDS2014B',
        'Serial Number,C050123',
        'Firmware Version,FV:v22.11',
    ]
    left = [q if q else ',' for q in left]
    b = ''.join(f'{left[i] if i < len(left) else ","},,{t[i]:.12f},{V[i]:9.5f},\n' for i in range(n))
    save(nm, b, nl='\r\n')
    expect(
        nm,
        'Tektronix TDS2014B single channel CSV, settings in the two left columns of the first rows, probe x10 already applied',
        [(t, {'voltage': ('V', V)})],
        "only the voltage on CH1 (across the muscle) was recorded; nothing says so beyond 'CH1' and V",
    )


# 16 Keysight InfiniiVision
def f16():
    nm = 'scope_12.csv'
    S = sim(16, 80, 0.04, step(8, 45), tau=8)
    t = r(S['t'] - 8, 3)
    V, sh = r(S['V'], 3), r(S['I'] * 1.0, 5)
    save(
        nm,
        'x-axis,1,2\nsecond,Volt,Volt\n' + ''.join(f'{a:+.8E},{c:+.5E},{e:+.5E}\n' for a, c, e in zip(t, V, sh)),
        nl='\r\n',
    )
    h = {'needs_hint': True}
    expect(
        nm,
        'Keysight InfiniiVision, 1 = voltage across muscle, 2 = voltage over a 1 ohm shunt',
        [(t, {'voltage': ('V', V, h), 'current': ('V', sh, {'conv': 1, 'needs_hint': True})})],
        'both columns are just Volt: 1 is across the muscle, 2 is a 1 ohm shunt (so V = A)',
    )


# 17 Rigol
def f17():
    nm = 'NewFile3.csv'
    n = 1200
    S = sim(17, 0, 0.1, step(12, 70), n=n, Ta=22)
    V, tc = r(S['V'], 2), r(S['T'] * 0.005, 4)
    b = ''.join(f'{i},{a:.2e},{c:.3e},\n' for i, (a, c) in enumerate(zip(V, tc)))
    V = np.array([float(f'{a:.2e}') for a in V])
    tc = np.array([float(f'{a:.3e}') for a in tc])
    save(nm, 'X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.200000e+01,1.000000e-01\n' + b, nl='\r\n')
    h = {'needs_hint': True}
    expect(
        nm,
        'Rigol DS1054Z, X is a sample number, start and increment in the heading; CH2 is an AD8495 thermocouple amplifier',
        [
            (
                S['t'] - 12,
                {
                    'voltage': ('V', V, h),
                    'temperature': ('V', tc, {'conv': lambda a: a / 0.005 + K, 'needs_hint': True}),
                },
            )
        ],
        'CH1 is the voltage across the muscle, CH2 a thermocouple amplifier with 5 mV per degC (0 V = 0 degC)',
    )


# 18 Keithley DMM6500 buffer
def f18():
    nm = 'defbuffer1.csv'
    S = sim(18, 180, 0.15, step(15, 95), jitter=0.003, R0=41.2, alpha=3.8e-4)
    t, R_ = r(S['t'], 6), r(S['R'], 6)
    t0 = dt.datetime(2023, 2, 21, 11, 4, 51)
    h = (
        'Keithley Instruments,MODEL DMM6500,04412345,1.7.8b\nBuffer,defbuffer1\nBase Time,02/21/2023 11:04:51\n\n'
        'Index,Reading,Unit,Range Digits,Disp Digits,Math,Start Group,Limit1 High,Limit1 Low,Terminal,Questionable,Origin,Date,Time,Fractional Seconds,Relative Time,Channel\n'
    )
    b = ''
    for i, (s, v) in enumerate(zip(t, R_)):
        q = t0 + dt.timedelta(seconds=int(s))
        b += f'{i + 1},{v:.9E},Ohm,5,6,F,F,F,F,Front,F,Main,{q:%m/%d/%Y},{q:%H:%M:%S},{s % 1:.6f},{s:.6f},\n'
    save(nm, h + b, nl='\r\n')
    expect(
        nm,
        'Keithley DMM6500 buffer saved to USB, four-wire resistance only',
        [(t, {'resistance': ('ohm', R_)})],
        'only resistance: the current was not logged',
    )


# 19 Keithley 2450 SMU via KickStart
def f19():
    nm = 'KickStart_2450_IVt.csv'
    S = sim(19, 120, 0.1, step(10, 65))
    t = r(S['t'], 4)
    I, V = (
        np.array([float(f'{a:.5e}') for a in S['u'] + S['g'].normal(0, 2e-6, len(t))]),
        np.array([float(f'{a:.5e}') for a in S['V']]),
    )
    h = '"Instrument","2450"\n"Serial","04098765"\n"Test","I-Bias, V-measure"\n"Source Function","Current"\n"Source Limit (V)","20"\n\n"Reading #","Relative Time (s)","SMU-1 Current (A)","SMU-1 Voltage (V)","Status"\n'
    save(
        nm,
        h + ''.join(f'{i + 1},{a:.4f},{c:.5e},{e:.5e},"OK"\n' for i, (a, c, e) in enumerate(zip(t, I, V))),
        nl='\r\n',
    )
    expect(
        nm,
        'Keithley 2450 SourceMeter through KickStart, current forced, voltage measured',
        [(t, {'current': ('A', I), 'voltage': ('V', V)})],
        None,
        'resistance = V/I while the current flows',
    )


# 20 Agilent BenchLink UTF-16
def f20():
    nm = 'Data 17 11_14_2023 10_22_18.csv'
    S = sim(20, 480, 1.2, square(24, 200, 0.5, 2), jitter=0.01)
    t = r(S['t'], 3)
    T, A, V, I = r(S['T'], 3), r(S['A'], 3), r(S['V'], 5), r(S['I'], 6)
    t0 = dt.datetime(2023, 11, 14, 10, 22, 19, 12000)
    h = (
        'Name:,C:\\BenchLink\\tcp17.csv\nOwner:,\nComments:,TCP 17 with 100 g\nAcquisition Date:,11/14/2023 10:22:18\nInstrument 1:,34972A\nTotal Channels:,4\n'
        'Channel,Name,Function,Range,Resolution,Advanced settings,Scale,Gain,Offset,Label,Test,Low,High,HW Alarm,\n'
        '101,muscle,TEMPERATURE (Type K),N/A,C,INTEG 1 PLC,False,1,0,C,Off,0,0,None,\n102,room,TEMPERATURE (Type K),N/A,C,INTEG 1 PLC,False,1,0,C,Off,0,0,None,\n'
        '103,U,DC VOLTS,100 V,5.5 digits,INTEG 1 PLC,False,1,0,VDC,Off,0,0,None,\n121,I,DC CURRENT,1 A,5.5 digits,INTEG 1 PLC,False,1,0,ADC,Off,0,0,None,\n'
        'Scan Control:,\nStart Action:,Immediately\nStop Action:,User (Off)\n\nScan,Time,101 <muscle> (C),Alarm 101,102 <room> (C),Alarm 102,103 <U> (VDC),Alarm 103,121 <I> (ADC),Alarm 121,\n'
    )
    b = ''.join(
        f'{i + 1},{clock(t0, s, "%m/%d/%Y %H:%M:%S").replace(".", ":")},{a},0,{c},0,{e},0,{g},0,\n'
        for i, (s, a, c, e, g) in enumerate(zip(t, T, A, V, I))
    )
    with open(os.path.join(OUT, nm), 'wb') as f:
        f.write(b'\xff\xfe' + (h + b).replace('\n', '\r\n').encode('utf-16-le'))
    expect(
        nm,
        'Agilent 34972A BenchLink Data Logger, UTF-16 LE, milliseconds after a colon, alarm columns',
        [(t, {'temperature': ('degC', T), 'ambient': ('degC', A), 'voltage': ('V', V), 'current': ('A', I)})],
    )


# 21, 22 MATLAB
def fixmat(p):
    with open(p, 'rb') as f:
        b = bytearray(f.read())
    b[:116] = b'MATLAB 5.0 MAT-file, Platform: PCWIN64, Created on: Tue Mar 12 10:31:07 2024'.ljust(116)
    with open(p, 'wb') as f:
        f.write(b)


def f21():
    from scipy.io import savemat

    nm = 'trials_TCP_B.mat'
    runs = []
    el = []
    for k_, I0 in enumerate((0.18, 0.22, 0.26)):
        S = sim(210 + k_, 150 + 10 * k_, 0.1, step(10, 80), I0=I0)
        t, I, T, x = r(S['t'], 3), r(S['I'], 5), r(S['T'], 3), r(S['x'], 3)
        el.append((f'trial{k_ + 1}', t[:, None], I[:, None], T[:, None], x[:, None], 100.0))
        runs.append((t, {'current': ('A', I), 'temperature': ('degC', T), 'displacement': ('mm', x)}))
    d = np.zeros((1, 3), dtype=[(q, object) for q in ('name', 'time', 'current', 'temp', 'disp', 'load_g')])
    for i, e in enumerate(el):
        d[0, i] = e
    p = os.path.join(OUT, nm)
    savemat(p, {'trials': d, 'units': np.array(['s', 'A', 'degC', 'mm'], dtype=object)})
    fixmat(p)
    expect(
        nm,
        'MATLAB v5 struct array, three trials, units in a separate cell array',
        runs,
        notes='load is a constant dead weight of 100 g in a field',
    )


def f22():
    from scipy.io import savemat

    nm = 'run12_v7.mat'
    S = sim(22, 200, 0.05, sine(10, 0.02), I0=0.26)
    t, i, T, dx, R_ = r(S['t'], 3), r(S['I'] * 1e3, 2), r(S['T'] + K, 2), r(S['x'] / 1e3, 6), r(S['R'], 3)
    p = os.path.join(OUT, nm)
    savemat(
        p,
        {
            't_s': t[:, None],
            'I_mA': i[:, None],
            'T_K': T[:, None],
            'dx_m': dx[:, None],
            'R_ohm': R_[:, None],
            'fs': 20.0,
            'comment': 'sine 0.02 Hz, 150 g',
        },
        do_compression=True,
    )
    fixmat(p)
    expect(
        nm,
        'MATLAB v7 (compressed), plain vectors named with their units, sine drive',
        [(t, {'current': ('mA', i), 'temperature': ('K', T), 'displacement': ('m', dx), 'resistance': ('ohm', R_)})],
    )


# 23 matrix only in mat
def f23():
    from scipy.io import savemat

    nm = 'data.mat'
    S = sim(23, 100, 0.1, step(5, 55))
    t, V, T = r(S['t'], 2), r(S['V'], 3), r(S['T'], 2)
    p = os.path.join(OUT, nm)
    savemat(p, {'data': np.column_stack([t, V, T])})
    fixmat(p)
    h = {'needs_hint': True}
    expect(
        nm,
        'MATLAB, one N x 3 matrix called data',
        [(t, {'voltage': ('V', V, h), 'temperature': ('degC', T, h)})],
        'columns are time in s, voltage in V, temperature in degC',
    )


# 24 writetable
def f24():
    nm = 'T_run3.csv'
    S = sim(24, 180, 0.1, step(15, 95))
    t, V, T, st = r(S['t'], 2), r(S['V'], 3), r(S['T'], 2), r(S['x'], 3)
    T[[0, 1, 7, 300, 301]] = np.nan
    g = lambda v: 'NaN' if np.isnan(v) else f'{v:.15g}'
    save(
        nm,
        'Time_s,Voltage_V,Temp_degC,Stroke_mm,Valid\n'
        + ''.join(','.join(map(g, q)) + f',{int(np.isfinite(q[2]))}\n' for q in zip(t, V, T, st)),
    )
    expect(
        nm,
        'MATLAB writetable, first temperature cells NaN until the camera starts',
        [(t, {'voltage': ('V', V), 'temperature': ('degC', T), 'displacement': ('mm', st)})],
    )


# 25-28 xlsx
def xl_save(wb, nm):
    wb.properties.created = wb.properties.modified = dt.datetime(2024, 2, 2, 12)
    wb.properties.creator = 'lab'
    b = io.BytesIO()
    wb.save(b)
    z = zipfile.ZipFile(b)
    with zipfile.ZipFile(os.path.join(OUT, nm), 'w', zipfile.ZIP_DEFLATED) as o:
        for q in z.infolist():
            b = z.read(q)
            if q.filename == 'docProps/core.xml':
                b = re.sub(rb'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ', b'2024-02-02T12:00:00Z', b)
            o.writestr(zipfile.ZipInfo(q.filename, (2024, 2, 2, 12, 0, 0)), b, zipfile.ZIP_DEFLATED)


def f25():
    import openpyxl

    nm = 'TCP_experiments_Feb.xlsx'
    wb = openpyxl.Workbook()
    w = wb.active
    w.title = 'Parameters'
    runs = []
    for q in (
        ['Fibre', 'Nylon 6,6 235/34-4ply Ag'],
        ['Length (mm)', 130],
        ['Coil diameter (mm)', 0.72],
        ['Dead weight (g)', 100],
        ['Resistance cold (ohm)', 40.1],
        ['Operator', 'S.K.'],
    ):
        w.append(q)
    for k_, I0 in enumerate((0.20, 0.25, 0.28)):
        S = sim(250 + k_, 120 + 20 * k_, 0.2, step(10, 65), I0=I0, R0=40.1)
        w = wb.create_sheet(f'Run{k_ + 1}_{int(I0 * 1000)}mA')
        t, I, T, x = r(S['t'], 2), r(S['I'], 4), r(S['T'], 2), r(S['x'], 3)
        w.append(['Time (s)', 'Current (A)', 'Temperature (°C)', 'Displacement (mm)'])
        for q in zip(t, I, T, x):
            w.append([float(v) for v in q])
        runs.append((t, {'current': ('A', I), 'temperature': ('degC', T), 'displacement': ('mm', x)}))
    wb.create_sheet('Summary').append(['run', 'max stroke (mm)'])
    w = wb['Summary']
    for k_, q in enumerate(runs):
        w.append([k_ + 1, float(q[1]['displacement'][1].max())])
    xl_save(wb, nm)
    expect(nm, 'Excel workbook: Parameters sheet, three run sheets, Summary sheet', runs)


def f26():
    import openpyxl

    nm = '2024-02-02 heating test.xlsx'
    wb = openpyxl.Workbook()
    w = wb.active
    S = sim(26, 200, 0.25, step(20, 110))
    t, I, V, T, A, x = r(S['t'], 2), r(S['I'] * 1e3, 1), r(S['V'], 2), r(S['T'], 1), r(S['A'], 1), r(S['x'], 2)
    w['A1'] = 'Heating test, sample N-14, 02 Feb 2024'
    w.merge_cells('A1:F1')
    w['A2'] = 'fan off, hood closed'
    w['A4'] = 'Time'
    w['B4'] = 'Electrical'
    w.merge_cells('B4:C4')
    w['D4'] = 'Temperature'
    w.merge_cells('D4:E4')
    w['F4'] = 'Motion'
    for c, a, b in zip(
        'ABCDEF', ['t', 'Current', 'Voltage', 'Coil', 'Room', 'Contraction'], ['s', 'mA', 'V', '°C', '°C', 'mm']
    ):
        w[c + '5'] = a
        w[c + '6'] = b
    for q in zip(t, I, V, T, A, x):
        w.append([float(v) for v in q])
    xl_save(wb, nm)
    expect(
        nm,
        'Excel sheet with title rows, merged group headings, names row, units row',
        [
            (
                t,
                {
                    'current': ('mA', I),
                    'voltage': ('V', V),
                    'temperature': ('degC', T),
                    'ambient': ('degC', A),
                    'displacement': ('mm', x),
                },
            )
        ],
    )


def f27():
    import openpyxl

    nm = 'compare_weights.xlsx'
    wb = openpyxl.Workbook()
    w = wb.active
    w.title = 'Sheet1'
    runs = []
    for k_, (g, n) in enumerate(((50, 601), (100, 551), (150, 701))):
        S = sim(270 + k_, 0, 0.2, step(10, 62), n=n, stroke=0.26 - 0.03 * k_)
        t, T, x = r(S['t'], 1), r(S['T'], 1), r(S['x'], 2)
        c0 = 1 + 4 * k_
        w.cell(1, c0, f'{g} g')
        w.merge_cells(start_row=1, end_row=1, start_column=c0, end_column=c0 + 2)
        for j, (h, a) in enumerate((('Time (s)', t), ('Temp (°C)', T), ('Stroke (mm)', x))):
            w.cell(2, c0 + j, h)
            for i, v in enumerate(a):
                w.cell(3 + i, c0 + j, float(v))
        runs.append((t, {'temperature': ('degC', T), 'displacement': ('mm', x)}))
    xl_save(wb, nm)
    expect(
        nm,
        'Excel, three runs as column blocks side by side, of different lengths, an empty column between',
        runs,
        'the current is not in the file',
        'the weights 50/100/150 g stand above the blocks',
    )


def f28():
    import openpyxl

    nm = 'Logger_export_0521.xlsx'
    wb = openpyxl.Workbook()
    w = wb.active
    w.title = 'Log'
    S = sim(28, 900, 2.0, square(60, 300, 0.4, 3))
    t, I, T = S['t'], r(S['I'], 3), r(S['T'], 1)
    w.append(['Date/Time', 'PSU current [A]', 'TC1 [°C]'])
    t0 = dt.datetime(2024, 5, 21, 16, 30)
    for a, b, c in zip(t, I, T):
        w.append([t0 + dt.timedelta(seconds=float(a)), float(b), float(c)])
        w.cell(w.max_row, 1).number_format = 'yyyy-mm-dd hh:mm:ss'
    xl_save(wb, nm)
    expect(nm, 'Excel with true date-time cells', [(t, {'current': ('A', I), 'temperature': ('degC', T)})])


# 29 parquet, 30 to_csv
def f29():
    import pandas as pd

    nm = 'session_0007.parquet'
    S = sim(29, 240, 0.1, stairs([0, 0.6, 0.8, 1, 0, 0, 1], 30))
    t = r(S['t'], 1)
    P, T, R_, F = r(S['P'], 4), r(S['T'] + K, 2), r(S['R'], 3), r(S['F'] * 1e3, 1)
    pd.DataFrame(
        {
            'timestamp': pd.Timestamp('2024-07-03T08:00:00Z') + pd.to_timedelta((t * 1e3).astype(int), unit='ms'),
            'power_W': P,
            'temperature_K': T,
            'resistance_ohm': R_,
            'force_mN': F,
            'sample': 'B7',
        }
    ).to_parquet(os.path.join(OUT, nm))
    expect(
        nm,
        'Python acquisition with pandas to parquet, UTC timestamps, units in the column names',
        [(t, {'power': ('W', P), 'temperature': ('K', T), 'resistance': ('ohm', R_), 'load': ('mN', F)})],
    )


def f30():
    import pandas as pd

    nm = 'df_out.csv'
    S = sim(30, 120, 0.1, step(10, 60))
    t = r(S['t'], 1)
    I, T, x = r(S['I'], 5), r(S['T'], 3), r(S['x'], 4)
    pd.DataFrame({'time': t, 'current_A': I, 'temp_C': T, 'contraction_mm': x}).to_csv(os.path.join(OUT, nm))
    expect(
        nm,
        'pandas to_csv with the nameless index column',
        [(t, {'current': ('A', I), 'temperature': ('degC', T), 'displacement': ('mm', x)})],
        None,
        "'time' has no unit; seconds is the plain reading (0.1 steps)",
    )


# 31 numpy savetxt, 32 % comments
def f31():
    nm = 'tcp_2023-08-30_a.dat'
    S = sim(31, 160, 0.1, step(10, 85))
    t, I, T, R_ = (np.array([float(f'{v:.6e}') for v in S[q]]) for q in ('t', 'I', 'T', 'R'))
    save(
        nm,
        '# TCP muscle, thermocouple K glued with Kapton\n# fs = 10 Hz, weight 100 g\n# t[s]\tI[A]\tT[degC]\tR[Ohm]\n'
        + ''.join('\t'.join(f'{v:.6e}' for v in q) + '\n' for q in zip(t, I, T, R_)),
    )
    expect(
        nm,
        'Python numpy.savetxt, tab separated, the heading is the last # comment',
        [(t, {'current': ('A', I), 'temperature': ('degC', T), 'resistance': ('ohm', R_)})],
    )


def f32():
    nm = 'ir_camera_roi1.asc'
    S = sim(32, 150, 1 / 15, square(10, 45, 0.5, 3), tau=10)
    t, T, A = r(S['t'], 4), r(S['T'], 2), r(S['A'], 2)
    save(
        nm,
        '% FLIR A655sc  ROI 1 (coil) mean, ROI 2 (background) mean\n% emissivity 0.95, distance 0.3 m, reflected temperature 22 C\n% frame   time_s   ROI1_mean_C   ROI2_mean_C\n'
        + ''.join(f'{i:6d} {a:10.4f} {b:8.2f} {c:8.2f}\n' for i, (a, b, c) in enumerate(zip(t, T, A))),
    )
    expect(
        nm,
        'FLIR infrared camera ROI statistics, % comments, space separated',
        [(t, {'temperature': ('degC', T), 'ambient': ('degC', A)})],
        'no drive in the file; ROI2 is the background, i.e. the room',
        'ambient = ROI 2 (background) by the first comment line',
    )


# 33 fixed width
def f33():
    nm = 'OUT33.PRN'
    S = sim(33, 100, 0.1, step(8, 55))
    t, I, T, F = r(S['t'], 2), r(S['I'] * 1e3, 2), r(S['T'], 2), r(S['F'], 4)
    save(
        nm,
        '  MUSCLE TEST 33      OPERATOR JB       14-OCT-2021\n\n      TIME   CURRENT      TEMP      LOAD\n       (S)      (MA)   (DEG C)       (N)\n'
        + ''.join(f'{a:10.2f}{b:10.2f}{c:10.2f}{d:10.4f}\n' for a, b, c, d in zip(t, I, T, F)),
        nl='\r\n',
    )
    expect(
        nm,
        'Fixed width Fortran-style print file, units row in capitals (MA means mA here)',
        [(t, {'current': ('mA', I), 'temperature': ('degC', T), 'load': ('N', F)})],
    )


# 34 Influx long format, 35 Grafana ISO with tz
def f34():
    nm = 'influx_query.csv'
    S = sim(34, 300, 1.0, step(30, 170))
    t = S['t']
    I, T, x = r(S['I'], 4), r(S['T'], 2), r(S['x'], 2)
    t0 = dt.datetime(2024, 3, 18, 9, 12, 7)
    h = '#group,false,false,true,true,false,false,true,true\n#datatype,string,long,dateTime:RFC3339,dateTime:RFC3339,dateTime:RFC3339,double,string,string\n#default,_result,,,,,,,\n,result,table,_start,_stop,_time,_value,_field,_measurement\n'
    b = ''.join(
        f',,{k_},2024-03-18T09:00:00Z,2024-03-18T10:00:00Z,{clock(t0, s, "%Y-%m-%dT%H:%M:%S", False)}Z,{v},{fn},tcp_rig\n'
        for k_, (fn, a) in enumerate((('current_A', I), ('stroke_mm', x), ('temperature_C', T)))
        for s, v in zip(t, a)
    )
    save(nm, h + b, nl='\r\n')
    expect(
        nm,
        'InfluxDB annotated CSV in long form (one reading per row, three fields)',
        [(t, {'current': ('A', I), 'temperature': ('degC', T), 'displacement': ('mm', x)})],
        notes='rows = instants; the file has three times as many lines',
    )


def f35():
    nm = 'grafana_data_export.csv'
    S = sim(35, 420, 0.5, square(30, 180, 0.45, 2))
    t = r(S['t'], 1)
    P, T = r(S['P'], 3), r(S['T'], 1)
    t0 = dt.datetime(2024, 3, 31, 1, 57)

    def iso(s):  # over the change to summer time in Europe
        q = t0 + dt.timedelta(milliseconds=int(round(s * 1000)))
        d = q >= dt.datetime(2024, 3, 31, 2)
        if d:
            q += dt.timedelta(hours=1)
        return f'{q:%Y-%m-%dT%H:%M:%S}.{q.microsecond // 1000:03d}{"+02:00" if d else "+01:00"}'

    save(
        nm,
        '"Time","Heater power","Muscle temp"\n'
        + ''.join(f'{iso(s)},{a:.3f} W,{b:.1f} °C\n' for s, a, b in zip(t, P, T)),
    )
    expect(
        nm,
        'Grafana CSV, ISO time with zone (over the change to summer time), unit in every cell',
        [(t, {'power': ('W', P), 'temperature': ('degC', T)})],
    )


# 36 midnight
def f36():
    nm = 'night_run.csv'
    S = sim(36, 900, 1.0, square(60, 200, 0.5, 4))
    t = S['t']
    I, T, x = r(S['I'], 3), r(S['T'], 1), r(S['x'], 1)
    t0 = dt.datetime(2022, 12, 1, 23, 52, 30)
    save(
        nm,
        'Time,Current (A),Temp (C),Disp (mm)\n'
        + ''.join(f'{clock(t0, s, ms=False)},{a:.3f},{b:.1f},{c:.1f}\n' for s, a, b, c in zip(t, I, T, x)),
        nl='\r\n',
    )
    expect(
        nm,
        'Clock times without a date, running over midnight',
        [(t, {'current': ('A', I), 'temperature': ('degC', T), 'displacement': ('mm', x)})],
    )


# 37 epoch ms, 38 JSON lines
def f37():
    nm = 'mqtt_muscle.csv'
    S = sim(37, 200, 0.25, step(15, 100), jitter=0.02)
    ms = np.round(S['t'] * 1e3).astype(np.int64) + 1709912345678
    I, V, T = r(S['I'] * 1e3, 0), r(S['V'], 2), r(S['T'], 1)
    save(
        nm,
        'ts;bus_mV;current_mA;tempC\n'
        + ''.join(f'{a};{round(v * 1000)};{int(b)};{c:.1f}\n' for a, v, b, c in zip(ms, V, I, T)),
    )
    expect(
        nm,
        'Node-RED/MQTT log, epoch milliseconds, semicolons with decimal points',
        [
            (
                (ms - ms[0]) / 1e3,
                {'voltage': ('mV', np.round(V * 1000)), 'current': ('mA', I), 'temperature': ('degC', T)},
            )
        ],
    )


def f38():
    nm = 'rig.jsonl'
    S = sim(38, 120, 0.2, step(10, 60), jitter=0.01)
    ts = r(S['t'] + 1718000000.25, 3)
    I, T, x = r(S['I'], 4), r(S['T'], 2), r(S['x'] * 1e3, 0)
    save(
        nm,
        ''.join(
            json.dumps({'ts': float(a), 'current_A': float(b), 'temp_C': float(c), 'disp_um': int(d)}) + '\n'
            for a, b, c, d in zip(ts, I, T, x)
        ),
    )
    expect(
        nm,
        'JSON lines from a Raspberry Pi script, epoch seconds, displacement in um',
        [(ts, {'current': ('A', I), 'temperature': ('degC', T), 'displacement': ('um', x)})],
    )


# 39 minutes + K
def f39():
    nm = 'long_soak.csv'
    S = sim(39, 3600, 3.0, stairs([0, 0.5, 0.7, 0.85, 1, 0.85, 0.7, 0.5], 400), tau=60)
    m = r(S['t'] / 60, 2)
    V, T, A = r(S['V'], 3), r(S['T'] + K, 1), r(S['A'] + K, 1)
    save(nm, 'Time (min),Voltage (V),T muscle (K),T room (K)\n' + table([m, V, T, A], [2, 3, 1, 1]))
    expect(
        nm,
        'Slow staircase, time in minutes, temperatures in kelvin',
        [(m * 60, {'voltage': ('V', V), 'temperature': ('K', T), 'ambient': ('K', A)})],
    )


# 40 run column, 41 blank-line blocks
def f40():
    nm = 'all_trials.csv'
    runs = []
    b = 'subject,trial,t,I_mA,T_C,stroke_mm\n'
    for k_, I0 in enumerate((0.2, 0.22, 0.25, 0.27)):
        S = sim(400 + k_, 80 + 5 * k_, 0.2, step(5, 42), I0=I0, tau=10)
        t, I, T, x = r(S['t'], 1), r(S['I'] * 1e3, 1), r(S['T'], 1), r(S['x'], 2)
        b += ''.join(f'TCP-A,{k_ + 1},{p:.1f},{q:.1f},{u:.1f},{v:.2f}\n' for p, q, u, v in zip(t, I, T, x))
        runs.append((t, {'current': ('mA', I), 'temperature': ('degC', T), 'displacement': ('mm', x)}))
    save(nm, b)
    expect(nm, 'Tidy CSV with a trial column, time starts again in each', runs)


def f41():
    nm = 'sweep.gp'
    runs = []
    b = '# gnuplot data, one index per amplitude\n'
    for k_, I0 in enumerate((0.15, 0.20, 0.25)):
        S = sim(410 + k_, 90, 0.15, step(6, 50), I0=I0)
        t, I, T = r(S['t'], 2), r(S['I'], 4), r(S['T'], 2)
        b += f'# I0 = {I0:.2f} A\n#time/s current/A temperature/degC\n' + table([t, I, T], [2, 4, 2], ' ') + '\n\n'
        runs.append((t, {'current': ('A', I), 'temperature': ('degC', T)}))
    save(nm, b)
    expect(nm, 'gnuplot file, runs separated by two blank lines, comments before each', runs)


# 42 handheld DMM with OL and ---
def f42():
    nm = 'UT61E_and_TC.csv'
    S = sim(42, 300, 0.5, step(20, 150))
    t = r(S['t'], 1)
    R_, T = r(S['R'] / 1e3, 5), r(S['T'], 1)
    t0 = dt.datetime(2023, 10, 2, 17, 5, 1)
    R_[[0, 1, 2, 250, 251]] = np.nan
    T[[5, 6, 333]] = np.nan
    save(
        nm,
        'No.,Time,Resistance,Unit,T1,Unit\n'
        + ''.join(
            f'{i + 1},{clock(t0, s).rstrip("0").rstrip(".") if s % 1 == 0 else clock(t0, s)[:-2]},{"OL" if np.isnan(a) else f"{a:.5f}"},kOhm,{"---" if np.isnan(b) else f"{b:.1f}"},degC\n'
            for i, (s, a, b) in enumerate(zip(t, R_, T))
        ),
        nl='\r\n',
    )
    expect(
        nm,
        'Handheld multimeter log: OL, ---, unit columns, kOhm',
        [(t, {'resistance': ('kOhm', R_), 'temperature': ('degC', T)})],
        'the drive is not in the file',
    )


# 43 English thousands, all quoted
def f43():
    nm = 'export_quoted.csv'
    S = sim(43, 150, 0.1, step(10, 75))
    ms = r(S['t'] * 1e3, 0)
    V, I, T = r(S['V'] * 1e3, 1), r(S['I'] * 1e3, 2), r(S['T'], 2)
    q = lambda v, n: f'"{v:,.{n}f}"'
    save(
        nm,
        '"Elapsed (ms)","Voltage (mV)","Current (mA)","Temperature (°C)"\n'
        + ''.join(','.join([q(a, 0), q(b, 1), q(c, 2), q(d, 2)]) + '\n' for a, b, c, d in zip(ms, V, I, T)),
        'utf-8-sig',
        '\r\n',
    )
    expect(
        nm,
        'US database export, every number quoted with thousands commas, BOM',
        [(ms / 1e3, {'voltage': ('mV', V), 'current': ('mA', I), 'temperature': ('degC', T)})],
    )


# 44 Swiss
def f44():
    nm = 'ETH_Messreihe.txt'
    S = sim(44, 100, 0.1, step(8, 55))
    ms = r(S['t'] * 1e3, 0)
    x, P = r(S['x'] * 1e3, 1), r(S['P'] * 1e3, 1)
    q = lambda v, n: f'{v:,.{n}f}'.replace(',', '’')
    save(
        nm,
        'Zeit (ms)\tVerkürzung (µm)\tLeistung (mW)\n'
        + ''.join('\t'.join([q(a, 0), q(b, 1), q(c, 1)]) + '\n' for a, b, c in zip(ms, x, P)),
    )
    expect(
        nm,
        'Swiss number format with ’ as thousands sign, um and mW',
        [(ms / 1e3, {'displacement': ('um', x), 'power': ('mW', P)})],
    )


# 45 CR only
def f45():
    nm = 'Igor_wave_export'
    S = sim(45, 120, 0.1, step(10, 65))
    t, I, T, x = r(S['t'], 1), r(S['I'], 5), r(S['T'], 3), r(S['x'], 4)
    save(nm, 'time_s\tcurrent_A\ttemp_C\tstroke_mm\n' + table([t, I, T, x], [1, 5, 3, 4], '\t'), nl='\r')
    expect(
        nm,
        'Igor Pro delimited text on an old Mac, CR line ends, no file suffix',
        [(t, {'current': ('A', I), 'temperature': ('degC', T), 'displacement': ('mm', x)})],
    )


# 46 imperial
def f46():
    nm = 'ME421 Lab 6 Team 3.csv'
    S = sim(46, 180, 0.5, step(15, 95), Ta=22)
    t, I, T, x, F = r(S['t'], 1), r(S['I'], 3), r(S['T'] * 1.8 + 32, 1), r(S['x'] / 25.4, 4), r(S['F'] / 4.4482216, 4)
    save(
        nm,
        'ME 421 Lab 6,,,,\nTeam 3: artificial muscle,,,,\n,,,,\nTime,Current,Temp,Displacement,Load\n(sec),(amps),(deg F),(in),(lbf)\n'
        + table([t, I, T, x, F], [1, 3, 1, 4, 4])
        + ',,,,\n,,,,\n',
        nl='\r\n',
    )
    expect(
        nm,
        'US undergraduate lab, inches, lbf, degF, units row, trailing empty rows',
        [(t, {'current': ('A', I), 'temperature': ('degF', T), 'displacement': ('inch', x), 'load': ('lbf', F)})],
    )


# 47 Keyence distance falling, mass on a scale
def f47():
    nm = 'LK-G_kyori.csv'
    S = sim(47, 160, 0.05, square(10, 50, 0.5, 3), tau=10)
    t = r(S['t'], 2)
    d = r(30 - S['x'], 3)
    I = r(S['I'] * 1e3, 1)
    save(
        nm,
        'Laser distance vs current\nsampling,50ms\nTime[s],Distance[mm],Current[mA]\n' + table([t, d, I], [2, 3, 1]),
        nl='\r\n',
    )
    expect(
        nm,
        'Keyence laser above the weight: distance 30 mm falls as the muscle contracts',
        [
            (
                t,
                {
                    'displacement': ('mm', d, {'note': 'as recorded (distance); contraction = 30 mm minus it'}),
                    'current': ('mA', I),
                },
            )
        ],
        notes='distance falls while heating, contraction is first minus distance',
    )


# 48 Instron with strain, length in preamble
def f48():
    nm = 'Specimen_RawData_1.csv'
    S = sim(48, 200, 0.1, step(15, 105))
    t, e, F, T = r(S['t'], 3), r(S['x'] / 125 * 100, 4), r(S['F'], 5), r(S['T'], 2)
    h = '"Test method","TCP isotonic.is_tcyclic"\n"Specimen label","nylon 14"\n"Length","125.00","mm"\n"Geometry","Circular"\n"Load control","1.0","N"\n\n"Time","Contraction strain","Load","TC input"\n"(sec)","(%)","(N)","(C)"\n'
    save(nm, h + ''.join(f'"{a:.3f}","{b:.4f}","{c:.5f}","{d:.2f}"\n' for a, b, c, d in zip(t, e, F, T)), nl='\r\n')
    expect(
        nm,
        'Instron Bluehill raw data, quoted, strain in %, specimen length 125 mm in the preamble',
        [
            (
                t,
                {
                    'displacement': ('%', e, {'conv': 1.25e-3, 'note': 'strain x 125 mm'}),
                    'load': ('N', F),
                    'temperature': ('degC', T),
                },
            )
        ],
        'the drive is not in the file',
    )


# 49 PWM duty
def f49():
    nm = 'pwm_drive_12V.txt'
    S = sim(49, 180, 0.2, step(10, 90), I0=0.25)
    D = np.where(S['u'] > 0, 70, 0)
    t, T, x, A = r(S['t'], 1), r(S['T'], 2), r(S['x'], 2), r(S['A'], 1)
    save(
        nm,
        '// supply: 12.0 V\n// muscle resistance: 40.0 ohm\n// PWM 1 kHz\nt_s\tduty_%\tT_C\tTroom_C\tx_mm\n'
        + ''.join(f'{a:.1f}\t{int(p)}\t{b:.2f}\t{c:.1f}\t{d:.2f}\n' for a, p, b, c, d in zip(t, D, T, A, x)),
    )
    expect(
        nm,
        'Microcontroller PWM: duty in %, supply voltage and resistance in // comments',
        [(t, {'temperature': ('degC', T), 'ambient': ('degC', A), 'displacement': ('mm', x)})],
        None,
        'drive is the duty (0 to 70 %): power = duty x 12^2/40 = 2.52 W at most, rms current 0.251 A',
        derived={'power': {'unit_in_file': '% duty', 'first_si': 0.0, 'max_si': 0.7 * 144 / 40, 'last_si': 0.0}},
    )


# 50 PicoLog
def f50():
    nm = 'PicoLog6-export.csv'
    S = sim(50, 600, 1.0, square(40, 260, 0.5, 2))
    t, T, A = S['t'], r(S['T'], 2), r(S['A'], 2)
    t0 = dt.datetime(2024, 6, 11, 10, 0, 3)
    T[400:412] = np.nan
    save(
        nm,
        '"","TC-08 Ch1 muscle Last (°C)","TC-08 CJC Last (°C)"\n'
        + ''.join(
            f'{clock(t0, s, "%Y-%m-%dT%H:%M:%S", False)}+01:00,{fx(a, 2)},{fx(b, 2)}\n' for s, a, b in zip(t, T, A)
        ),
    )
    expect(
        nm,
        'PicoLog 6 with TC-08, nameless time column with zone, a gap of empty cells',
        [(t, {'temperature': ('degC', T), 'ambient': ('degC', A, {'note': 'cold junction, near room temperature'})})],
        'drive not recorded here',
    )


# 51 two time bases side by side
def f51():
    nm = 'Origin_book1.txt'
    S = sim(51, 150, 0.1, step(10, 80))
    t1, I = r(S['t'], 1), r(S['I'], 4)
    t2, T = r(S['t'][::5], 1), r(S['T'][::5], 1)
    b = ''
    for i in range(len(t1)):
        b += f'{t1[i]}\t{I[i]:.4f}\t' + (f'{t2[i]}\t{T[i]:.1f}' if i < len(t2) else '\t') + '\n'
    save(nm, 'Time\tCurrent\tTime\tTemperature\ns\tA\ts\t°C\nPSU\tPSU\tthermo\tthermo\n' + b, nl='\r\n')
    expect(
        nm,
        'Origin worksheet export (long name, units, comments rows), current at 10 Hz and temperature at 2 Hz each with its own time',
        [(t1, {'current': ('A', I), 'temperature': ('degC', T)})],
        notes='one run: the temperature block has its own shorter time column (301 rows, 150 s)',
    )


# 52 only sampling rate
def f52():
    nm = 'daq_ai0_ai1.txt'
    S = sim(52, 0, 0.02, step(6, 40), n=4000, tau=9)
    V, T = r(S['V'], 4), r(S['T'], 3)
    save(
        nm,
        'Device: USB-6009\nSampling rate: 50 Hz\nSamples: 4000\nai0: V_muscle (V)   ai1: T_coil (degC)\n\nV_muscle,T_coil\n'
        + table([V, T], [4, 3]),
    )
    expect(
        nm,
        'NI USB-6009 script, no time column, sampling rate 50 Hz in the preamble',
        [(S['t'], {'voltage': ('V', V), 'temperature': ('degC', T)})],
    )


# 53 Tracker video
def f53():
    nm = 'tracker_massA.txt'
    S = sim(53, 60, 1 / 30, step(3, 30), tau=8)
    t, y = r(S['t'], 3), r(-0.212 + S['x'] / 1e3, 5)
    xx = r(S['g'].normal(0.0013, 5e-5, len(t)), 5)
    save(nm, 'mass_A\nt\tx\ty\n' + ''.join(f'{a:.3f}\t{b:.5f}\t{c:.5f}\n' for a, b, c in zip(t, xx, y)))
    expect(
        nm,
        'Tracker video analysis of the hanging weight, metres, y up',
        [
            (
                t,
                {
                    'displacement': (
                        'm',
                        y,
                        {'needs_hint': True, 'note': 'y as recorded, starts at -0.212 m; contraction = y - y[0]'},
                    )
                },
            )
        ],
        'y is the motion (m, up = contraction), x is sideways; no drive, no temperature',
    )


# 54 Korean, power supply
def f54():
    nm = '근육_전원기록.csv'
    S = sim(54, 240, 1.0, step(20, 130))
    t, V, I, T = S['t'], r(S['V'], 2), r(S['I'], 3), r(S['T'], 1)
    save(nm, '시간(초),전압(V),전류(A),온도(°C)\n' + table([t, V, I, T], [0, 2, 3, 1]), 'cp949', '\r\n')
    expect(
        nm,
        'Korean lab, power supply log, cp949',
        [(t, {'voltage': ('V', V), 'current': ('A', I), 'temperature': ('degC', T)})],
    )


# 55 Spanish, clock 12 h am/pm
def f55():
    nm = 'ensayo_12.csv'
    S = sim(55, 300, 1.0, step(30, 160))
    t = S['t']
    I, T, x = r(S['I'] * 1e3, 0), r(S['T'], 1), r(S['x'] / 10, 3)
    t0 = dt.datetime(2024, 4, 9, 11, 58, 20)
    save(
        nm,
        'Fecha;Hora;Corriente (mA);Temperatura (ºC);Desplazamiento (cm)\n'
        + ''.join(
            f'{q:%d/%m/%Y};{q:%I:%M:%S} {"a. m." if q.hour < 12 else "p. m."};{int(a)};{fx(b, 1, ",")};{fx(c, 3, ",")}\n'
            for q, a, b, c in ((t0 + dt.timedelta(seconds=float(s)), *z) for s, *z in zip(t, I, T, x))
        ),
        'cp1252',
        '\r\n',
    )
    expect(
        nm,
        "Spanish Excel, day/month date and 12-hour clock 'a. m./p. m.' over noon, cm",
        [(t, {'current': ('mA', I), 'temperature': ('degC', T), 'displacement': ('cm', x)})],
    )


# 56 descending duplicates: logger restarted, time resets, no blank line; cyc header repeated
def f56():
    nm = 'teraterm_2022-08-02.log'
    runs = []
    b = ''
    for k_ in range(2):
        S = sim(560 + k_, 70 + 12 * k_, 0.1, step(4, 36), tau=9)
        ms = np.round(S['t'] * 1e3).astype(int) + 31
        T, V, ld = r(S['T'], 2), r(S['V'], 2), r(S['F'] / 9.80665e-3, 1)
        b += 'millis,T(C),V(V),load(g)\n' + ''.join(
            f'{p},{q:.2f},{u:.2f},{v:.1f}\n' for p, q, u, v in zip(ms, T, V, ld)
        )
        b += '' if k_ else '4821,31.0\n'
        runs.append((ms / 1e3, {'temperature': ('degC', T), 'voltage': ('V', V), 'load': ('gf', ld)}))
    save(nm, b, nl='\r\n')
    expect(
        nm,
        'Tera Term log: board reset in the middle, heading printed again, one cut line before the reset',
        runs,
        notes="load cell in grams, i.e. gf; the cut line '4821,31.0' is garbage",
    )


def write(folder):
    """Write all files; what is in each, by its name."""
    global OUT
    OUT = str(folder)
    EXP.clear()
    for _, f in sorted((q, v) for q, v in globals().items() if len(q) == 3 and q[0] == 'f' and q[1:].isdigit()):
        f()
    return dict(EXP)
