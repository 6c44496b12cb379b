"""The words with which labs name what they measure, in their languages."""

# A word that begins so says what is measured. Longer words come first where one begins as another does.
BEGINNINGS = {
    'time': (
        'time zeit uhrzeit datum date prüfzeit temps tiempo tempo elapsed epoch timestamp stamp clock '
        'seconds second millis micros 時間 時刻 经过 時分 时间 日付 経過 秒 시간 hora fecha heure tijd czas время'
    ),
    'temperature': 'temperat températ temp thermo tc roi 温度 糸温 coilt 온도 температур',
    'ambient': (
        'ambient amb room raum luft air umgebung ambiance ambiente chamber background hintergrund '
        'environ env surround surr bath infinity inf omgeving otoczeni 室温 環境 外気 环境 실온 실내 комнат окружающ'
    ),
    'resistance': 'resist résist widerst weerstand rezyst opór 抵抗 电阻 電阻 저항 сопротивлен',
    'current': (
        'current strom heizstrom intensit courant corrente corriente amper shunt stroom prąd natężen 電流 电流 전류 ток'
    ),
    'voltage': 'voltage volt spannung tensione voltaje tensão spanning napięci 電圧 电压 印加電 전압 напряжен',
    'power': ('power leistung heizleistung puissance potenza potencia watt heater vermogen moc 電力 功率 전력 мощност'),
    'elongation': (
        'extension elongation dehnung verlängerung allongement allungamento wydłużen 伸び 伸長 伸长 Δl δl удлинен'
    ),
    'strain': 'strain ひずみ 歪み 应变 변형률',
    'distance': 'distance dist abstand entfernung afstand odległoś standoff gap 距離 距离 거리 расстояни',
    'length': 'length länge laenge longueur lunghezza longitud lengte długość 長さ 全長 长度 길이 длина',
    'displacement': (
        'disp displ stroke weg hub position pos déplac deplac spost desplaz laser encoder contraction '
        'kontraktion verfahrweg standardweg travel verkürz shorten shrink raccourc accorci acorta '
        'desloc verplaats przemieszcz potentiometer poti pot lvdt 変位 位移 収縮 변위 수축 перемещен сокращен'
    ),
    'force': (
        'force kraft effort forza fuerza loadcell standardkraft força kracht siła 張力 拉力 力 힘 장력 сила усили'
    ),
    'load': (
        'load last weight gewicht mass masse charge carico carga hanging belasting obciąż 荷重 负载 负荷 重り '
        '하중 нагрузк груз'
    ),
}
# What pulled at a muscle before its end was held: the load that it started from, though a word beside may say force.
PRELOADS = {
    'load': 'preload pretension vorlast vorspann vorkraft précharge precharge precarico precarica precarga 予荷重 预载'
}
# What turns, and is no channel whatever its degrees are.
ANGLES = {'angle': 'angle winkel drehwinkel angolo ángulo angulo ângulo kąt угол 角度 각도'}
DEGREES = ('deg', 'degs', 'degree', 'degrees', '°')
# A symbol that stands for itself; case counts.
SYMBOLS = {
    'time': 't ts',
    'temperature': 'T ϑ θ Theta theta',
    'resistance': 'R',
    'current': 'I i',
    'voltage': 'U V u v',
    'power': 'P p',
    'displacement': 'x X y Y z Z s dx dy dz d',
    'elongation': 'dL dl',
    'length': 'L l',
    'force': 'F f Fz Fx',
}
WHOLE = frozenset(  # no beginnings
    [
        'air', 'amb', 'date', 'disp', 'dist', 'env', 'fecha', 'force', 'gap', 'hora', 'hub', 'inf', 'last',
        'mass', 'masse', 'moc', 'roi', 'pos', 'pot', 'surr', 'tc', 'tempo', 'temps', 'time', 'weg',
    ]
)  # fmt: skip
MODIFIERS = {
    'commanded': 'set soll cmd command commanded target setpoint sollwert 設定 consigne',
    'muscle': (
        'muscle muskel coil wire draht drahttemp specimen fibre fiber sample probe tcp tca muscolo fil yarn 糸 筋肉'
    ),
}
MEASURED = frozenset(['meas', 'measured', 'actual'])
ROLES = {
    'index': 'index no nr number sample scan sequence 番号 point n lfd frame row id',
    'run': 'run trial versuch test experiment series serie lauf repeat rep essai prova 試行',
    'unit': 'unit units einheit 単位',
}
# Of what an instrument was set to, and of what it says of itself.
SETTINGS = frozenset(
    ['digits', 'limit', 'limits', 'alarm', 'alarms', 'math', 'terminal', 'questionable', 'origin', 'valid', 'status']
)
# What stands in place of a unit where nobody has scaled what an instrument or a program shows.
SHARES = ('%', 'percent', 'prozent')
RATIOS = ('mm/mm', 'm/m', 'in/in')
UNSCALED = frozenset(
    [
        *SHARES, *RATIOS,
        'count', 'counts', 'cnt', 'cts', 'raw', 'adc', 'lsb', 'bit', 'bits', 'digit', 'digits', 'div', 'divs',
        'au', 'a.u.', 'arb', 'arb.', 'step', 'steps', 'px', 'pixel', 'pixels', 'frame', 'frames', 'sample', 'samples',
        'tick', 'ticks', 'rpm', 'rad', 'bar', 'psi', 'pa', 'hpa', 'kpa', 'mpa', 'db', 'rh', '%rh', 'ε', 'µε', 'με',
        'rev', 'turns', 'umdrehungen', 'hz', 'khz',
    ]
)  # fmt: skip
