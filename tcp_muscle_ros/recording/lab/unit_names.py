"""How labs write units: to the names of ``units.UNITS``."""

import re
import unicodedata
from collections.abc import Mapping
from types import MappingProxyType

from tcp_muscle_ros.recording.units import UNITS

# As they are written once NFKC, spaces and points are taken away; case counts, for mW is no MW.
_WRITTEN = {
    's': 's 초 sec secs second seconds sek sekunde sekunden seg segundos secondes secondi 秒 Sec Second Seconds с сек',
    'ms': 'ms msec millis milliseconds millisecond msek ミリ秒 毫秒 milliseg мс',
    'us': 'us µs μs usec micros microseconds',
    'ns': 'ns nsec nanoseconds nanosec',
    'min': 'min mins minute minutes minuten 分 分钟 мин',
    'h': 'h hr hrs hour hours Std 時間h ч',
    'd': 'day days Tag Tage jour jours',
    'A': 'A a ADC Adc amp amps ampere amperes Amp Amps 安 А',
    'mA': 'mA ma milliamp milliamps mAmp 毫安 мА',
    'uA': 'uA µA μA',
    'V': 'V v volt volts Volt Volts VDC Vdc 伏 В',
    'mV': 'mV mv millivolt millivolts мВ',
    'W': 'W w watt watts Watt Watts Вт',
    'mW': 'mW mw milliwatt milliwatts мВт',
    'ohm': 'ohm ohms Ohm Ohms OHM Ω ω オーム 欧姆 Ом',
    'mohm': 'mohm mohms mOhm mOhms mΩ milliohm milliohms',
    'kohm': 'kohm kOhm kΩ KΩ kohms',
    'm': 'm meter metre meters metres м',
    'cm': 'cm centimeter centimetre см',
    'mm': 'mm millimeter millimetre millimeters Millimeter ミリ 毫米 мм',
    'um': 'um µm μm micron microns micrometer 微米 мкм',
    'in': 'in inch inches "',
    'N': 'N n newton newtons Newton Newtons 牛 Н',
    'mN': 'mN mn millinewton millinewtons мН',
    'kN': 'kN kn',
    'g': 'g gf gram grams gramm 克 グラム grf г',
    'kg': 'kg kgf Kg KG кг',
    'lbf': 'lbf lb lbs pound pounds',
    'K': 'K k kelvin Kelvin degK',
    'degC': 'degC °C ºC C c °c deg_C degc DegC Cel celsius Celsius Grad grad gradC 度 GradCelsius °С',
    'degF': 'degF °F F f °f degf DegF fahrenheit Fahrenheit',
}
WRITTEN: Mapping[str, str] = MappingProxyType(
    {word: name for name, words in _WRITTEN.items() for word in words.split()}
)


_MEGOHM = re.compile('M(?i:ohms?)')
_OTHERS = frozenset(
    ['mil', 'mils', 'thou', 'ft', 'feet', 'foot', 'yd', 'Å', 'oz', 'ozf', 'kip', 'dyn', 'mK', 'mC', 'mdegC', 'm°C']
)
_PREFIXED = re.compile(r'(?:[nuµμcdhkM]|da)[mNg]|[pnuµμkMG](?:[AVWΩ]|[Oo]hms?)|[mkc]?N[cm]?m|[hkMG]?Pa')
_RATE = re.compile(r'(.+)/(?:s|sec|min|h|mm|V)')
_SCALED = re.compile(  # a part of one, or any number after a sign of multiplication; a whole number is a range
    r'(?:[x×*·]\s*[\d.,/]+|0[.,]0*1|1/10+|(?:1e|10\s*\^?\s*)[-−]\d+)\s*[x×*·]?\s*([^\W\d_].*|[°"].*)', re.I
)


def unit_named(text: str) -> str | None:
    """The unit that a text is, as 'Deg. C', '［ｍｍ］' or 'mΩ'; None where it is none."""
    plain = unicodedata.normalize('NFKC', text).replace('Ω', 'Ω').strip()
    if len(plain) > 1 and plain[0] in '[(<{' and plain[-1] in '])>}':
        plain = plain[1:-1]
    plain = plain.replace(' ', '').replace('.', '')
    if _MEGOHM.fullmatch(plain):  # no lower case of it is one either
        return None
    capitals = plain.lower() if len(plain) > 1 and plain.isupper() else plain  # MA of a printer
    lower = plain[:1].lower() + plain[1:] if len(plain) > 3 else plain
    return WRITTEN.get(plain) or WRITTEN.get(lower) or WRITTEN.get(capitals)


def other_unit(text: str, quantity: str) -> bool:
    """Is a text a unit, but none of those that are known: cN, mil, mm/s, or so many of one of the quantity, x10 um?

    A word, as in T (core), is none, nor is what else a bracket may hold, as in R (10 mA) or Force (50 N).
    """
    plain = unicodedata.normalize('NFKC', text).strip('[(<{})>] ')
    if unit_named(plain):
        return False
    if scaled := _SCALED.fullmatch(plain):
        unit = unit_named(scaled[1])
        known = unit is not None and scaled[1] != 'k' and UNITS[unit].quantity == quantity
        return known or other_unit(scaled[1], quantity)
    if rate := _RATE.fullmatch(plain):
        return unit_named(rate[1]) is not None or other_unit(rate[1], quantity)
    return plain in _OTHERS or _PREFIXED.fullmatch(plain) is not None
