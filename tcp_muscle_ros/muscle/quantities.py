"""Names of the places in the arrays that the compiled model works on.

``q`` holds the quantities of one instant, ``u`` what is imposed on the muscle, ``x`` its state, ``y`` what is shown.
All SI, temperatures in K.
"""

# q: the quantities of one instant, filled from the surroundings to the sensors.
(
    TIME,  # s since the start
    TEMPERATURE,  # of the fibre
    AMBIENT,
    DRIVING_TEMPERATURE,  # the temperature that the contraction follows
    RATIO,  # modulus over modulus at T0
    STIFFNESS,  # N/m
    GAIN,  # m, the stroke gain B
    EXTRA,  # m, length added beside thermal and elastic
    FORCE,  # N, tension
    ELASTIC,  # m, elongation by the force
    LENGTH,  # m
    SLACK,  # 1 when the muscle hangs loose
    DRIVE,  # A, W or V behind the supply
    RESISTANCE,  # ohm
    CURRENT,  # A
    HEATING,  # W, Joule heat
    CONDUCTANCE,  # W/K, to the ambient
    CAPACITY,  # J/K
    HEAT,  # W, any further heat into the fibre
    SHOWN_TEMPERATURE,  # as the sensor shows it
    SHOWN_RESISTANCE,
    SHOWN_LENGTH,
    SHOWN_FORCE,
) = range(23)
N_QUANTITIES = 23

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
