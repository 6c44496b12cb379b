"""What to check on the rig before a finding is believed: one text for each effect, and nowhere else."""

# Each says what else looks the same, and a check that takes a minute or an hour, without a new diagnosis.
_CHECKS = {
    'resistance_strain': 'Pull the cold muscle by hand and watch the resistance: it must follow the length without any '
    'heat. If it jumps, look at the crimps instead.',
    'contact_shorting': 'Look whether coils touch when the muscle is fully contracted. Hang a heavier weight, so that '
    'they part: the resistance must then no longer fall.',
    'contact_resistance': 'Measure the resistance with four wires, at the muscle and at the clamps: the difference is '
    'that of the clamps. Tighten or clean them and record again.',
    'tcr_curvature': 'Put the unloaded muscle in an oven or a water bath at three temperatures and read the resistance '
    'at a small current.',
    'resistance_drift': 'Read the cold resistance before and after the recording. If it has not changed, look at the '
    'ohmmeter; if it has, at the silver coat and the crimps.',
    'supply_lag': 'Read the current at a shunt with an oscilloscope while the supply switches: how long does it take?',
    'natural_convection': 'Put a cover over the muscle so that no draught reaches it, and hold three currents until '
    'nothing changes: the warming per watt must fall as it gets hotter.',
    'radiation': 'Compare a shiny and a blackened muscle, or one in front of a warm plate. At the temperatures of a '
    'muscle radiation and free convection look nearly alike.',
    'airflow': 'Look for a fan, an open door or people walking by at the times that are given. Cover the muscle and '
    'repeat the recording: it must be gone.',
    'ambient_drift': 'Put a second thermometer in the air beside the muscle, and record it: it must drift as '
    'reported. Keep heaters and the supply away.',
    'motion_convection': 'Move the warm muscle quickly by hand, or with another load step, without changing the '
    'current: its temperature must dip.',
    'exposed_area': 'Compare holds at the same power under a light and a heavy weight: the stretched muscle must be '
    'cooler.',
    'heat_capacity': 'Vary the current a little about three mean temperatures: how far the temperature varies gives '
    'the heat capacity there. A scan of the fibre (DSC) shows the same.',
    'latent_heat': 'A scan of the fibre (DSC) shows a peak, if there is one. None is known of nylon below 120 degC: '
    'suspect the heat capacity, or water, first.',
    'moisture': 'Dry the muscle (an hour at 80 degC, or a night over silica gel) and record again at once: the effect '
    'must be gone, and come back in humid air.',
    'two_node': 'Switch the current off and watch thermometer and stroke: if the stroke lags behind the thermometer, '
    'the core lags behind the surface. First rule out a thermometer that lags.',
    'end_conduction': 'Touch the clamps: are they warm? Put a heat insulator between muscle and clamp, or use a longer '
    'muscle: the effect must shrink.',
    'elastocaloric': 'Change the weight quickly at no current: the temperature must jump up with the load, and down '
    'without it, and fade.',
    'creep': 'Hang the weight on the cold muscle and record for ten minutes without current: the length must creep and '
    'level off. Check that clamps and knots do not slip.',
    'viscous_flow': 'Mark the length of the cold muscle before and after the recording: it must have grown for good. '
    'Check that clamps and knots do not slip.',
    'hysteresis': 'Go slowly to the same temperature from below and from above: the strokes must differ, however long '
    'you wait. If they meet, it is a lag and no hysteresis.',
    'branch_cte': 'As for hysteresis, but with small turns: where the muscle turns from warming to cooling, the slope '
    'of stroke over temperature must change at once.',
    'shear_softening': 'Change the weight at three temperatures (held currents) and read the change of length: the '
    'stiffness must fall with temperature as reported.',
    'load_stroke': 'Heat in the same way under three weights: the stroke must change with the weight as reported. '
    'Check that the heavier weight does not touch anything.',
    'geometric_stiffening': 'Hang weights one after the other on the cold muscle and read the length: the curve must '
    'bend upwards as reported.',
    'cte_kink': 'Warm slowly, by less than 1 K/s, past the temperature that is given: the slope of stroke over '
    'temperature must change there.',
    'coil_contact': 'Look whether coils touch when the muscle is fully contracted. Hang a heavier weight: the end of '
    'the stroke must come later.',
    'slack': 'Is the cold muscle straight under this weight? Hang a heavier one: the part without motion at the '
    'beginning must be gone.',
    'first_cycle': 'Record five equal cycles after the muscle has rested for a day: only the first may differ.',
    'fatigue': 'Compare the stroke of the first and the last cycle at the same temperature; then let the muscle rest '
    'for a night. If the stroke comes back, it was creep.',
    'inertia': 'Tap the weight and film it: the swing must have the frequency that is given. A guide for the weight '
    'takes it away.',
    'friction': 'Turn pulleys and guides by hand; take them out if you can, so that the weight hangs freely: the dead '
    'band must be gone.',
    'torsional_leakage': 'Mark the end of the muscle and the weight with a line: does it turn? The end must be kept '
    'from turning, and stay free to move along.',
    'thermocouple_lag': 'Dip the warm sensor into cold water and read how long it takes for two thirds of the step. '
    'Press it closer to the muscle, or use a thinner one.',
    'thermocouple_gain': 'Compare the sensor with a good thermometer in water of 20 and 80 degC. If it is right there, '
    'its bead touches the muscle on one side only.',
    'temperature_offset': 'Put the sensor into ice water: does it read 0 degC? Or compare it with the room before the '
    'first heating.',
    'thermocouple_pickup': 'Reverse the current: what is shown must change by twice as much. A thin layer of varnish '
    'between bead and muscle takes it away.',
    'displacement_drift': 'Point the laser or the camera at something that does not move, and record for as long: the '
    'drift must be there. A warm stand or a loose clamp does the same.',
    'displacement_offset': 'Read the sensor at rest under the starting load: that is the zero of the stroke.',
    'clock_skew': 'Tap the weight with the hot wire of the thermometer, or switch a lamp that both see: the time '
    'between the two stamps is the delay.',
    'current_gain': 'Put a good ammeter in series at three currents, zero among them.',
    'stick_slip': 'Turn pulleys and guides by hand and listen: does the weight move in jerks? Let it hang freely: the '
    'jerks must be gone.',
    'free_conductance': 'Hold four currents until nothing changes: power over warming is the curve that is shown.',
    'free_capacity': 'Vary the current a little about four mean temperatures: how far the temperature varies gives '
    'the curve that is shown.',
    'free_resistance': 'Read the resistance at a small current at four temperatures, in an oven or a water bath.',
    'free_stroke': 'Warm slowly under this weight, by less than 1 K/s, and read the stroke over temperature: it is the '
    'curve that is shown.',
    'free_stiffness': 'Change the weight in small steps, cold and warm, and read the length: it is the curve that is '
    'shown.',
    'free_slow_state': 'Repeat the recording after a night of rest, and once more at once: in the first the slow part '
    'must be back where it began, in the second not yet.',
    'free_surroundings': 'What does the muscle touch, or what encloses it? Hang it freely in open air, and repeat: the '
    'slow part must be gone.',
    'free_delay': 'Switch a lamp that the sensor sees, or short the sensor, and compare the stamps: is it late by '
    "itself? If not, the delay is the muscle's.",
}  # fmt: skip
_ANY = 'Repeat the recording on another day, and with another specimen: a property of the muscle must be there again.'


def check_on_rig(effect: str) -> str:
    """What to check on the rig before a finding is believed."""
    return _CHECKS.get(effect, _ANY)


def has_check(effect: str) -> bool:
    """Whether an effect has a check of its own."""
    return effect in _CHECKS
