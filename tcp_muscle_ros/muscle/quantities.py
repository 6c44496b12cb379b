"""Names of the places in the arrays that the compiled model works on.

``q`` holds the quantities of one instant, ``u`` what is imposed on the muscle, ``x`` its state, ``y`` what is shown.
All SI, temperatures in K.
"""

# q: the quantities of one instant, filled from the surroundings to the sensors.
_QUANTITIES = (
    TIME,  # s since the start
    KIND,  # of the source: current, power or voltage
    HELD,  # 1 when something holds the end, else a load pulls
    COMPLIANCE,  # m/N, of what holds it
    COMMAND,  # A, W or V, as the source is set
    TEMPERATURE,  # of the fibre: what has resistance, loses heat and is measured
    CORE_TEMPERATURE,  # of what contracts and softens
    AMBIENT,
    DRIVING_TEMPERATURE,  # the temperature that the contraction follows
    RATIO,  # modulus over modulus at T0
    STIFFNESS,  # N/m
    GAIN,  # m, the stroke gain B
    THERMAL,  # m, elongation by temperature
    EXTRA,  # m, length added beside thermal and elastic
    FORCE,  # N, tension
    ELASTIC,  # m, elongation by the force
    EQUILIBRIUM_LENGTH,  # m, where forces balance, before inertia and friction
    UNSTUCK_LENGTH,  # m, where these bring the end if it does not stick
    LENGTH,  # m
    SLACK,  # 1 when the muscle hangs loose
    DRIVE,  # A, W or V behind the supply
    RESISTANCE,  # ohm
    SERIES,  # ohm, between the source and the muscle
    CURRENT,  # A
    POWER,  # W, given by the source
    HEATING,  # W, Joule heat in the muscle
    CONDUCTANCE,  # W/K, to the ambient
    CAPACITY,  # J/K
    HEAT,  # W, any further heat from outside
    EXCHANGE,  # W, heat from other parts of the muscle
    TEMPERATURE_RATE,  # K/s
    VELOCITY,  # m/s, dLENGTH/dt
    FORCE_RATE,  # N/s
    PRESENT_TEMPERATURE,  # as the sensor would show it without a delay
    SHOWN_TEMPERATURE,  # as the sensor shows it
    SHOWN_RESISTANCE,
    SHOWN_LENGTH,
    SHOWN_FORCE,
    SHOWN_CURRENT,
    SHOWN_VOLTAGE,
    SHOWN_POWER,
    BEYOND,  # 1 when what a table depends on is outside it
) = range(42)
N_QUANTITIES = len(_QUANTITIES)

# u: what is imposed, constant over a step. KIND: 0 current, 1 power, 2 voltage.
IN_KIND, IN_DRIVE, IN_LOAD, IN_AMBIENT, IN_HELD, IN_WALL, IN_COMPLIANCE, IN_ZERO = range(8)
N_INPUTS = 8

# x: the state; the effects' own states follow.
X_TIME, X_TEMPERATURE, X_HEATED, X_LOST = range(4)
N_STATES = 4

# y: what one reading shows, in the order of Reading.
(
    Y_TEMPERATURE,
    Y_FIBRE_TEMPERATURE,
    Y_RESISTANCE,
    Y_DISPLACEMENT,
    Y_FORCE,
    Y_LENGTH,
    Y_CURRENT,
    Y_VOLTAGE,
    Y_POWER,
    Y_IN_DOMAIN,
    Y_SLACK,
) = range(11)
N_OUTPUTS = 11
