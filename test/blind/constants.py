"""
Places of the numbers in the flat arrays that the second plant's equations read.

Numba unpacks a flat array in a fraction of a microsecond, a record of sixty fields in many.
"""

(
    X, V, P1, P2, Z, H, M1, M2, LINE_1, LINE_2, SPOOL_1, SPOOL_2, WARMTH, STRETCH, LOAD_V,
    TRAVEL, ELAPSED, TANK, SEAL, JET_1, JET_2,
) = range(21)  # fmt: skip
"""State: position [m], velocity [m/s], pressures [Pa], bristle deflection [m], film [-], gas
masses [kg], flows out of the lines [kg/s], spools [V], warmth [-], stretch [m], velocity of the
load [m/s], way gone [m] and time [s] so far, what a tank lacks [Pa], deflection of a seal [m],
flows that stir the gas [0.1 g/s]."""
STATES = 21

(
    STICKING, CONTACT, REST_START, SLIDE_START, SHARE, HELD, TARGET_1, TARGET_2, ANCHORS,
) = range(9)  # fmt: skip
"""Memory, constant between events: at rest (0, 1), stop touched (-1, 0, 1), start of the rest and
of the slide [s], share of F_smax - F_c that F_s was above F_c then [-], static friction held [N],
where the spools are drawn to [V], anchors of the elements [m]."""

CONSTANTS = (
    'cylinder.cap_area', 'cylinder.rod_area', 'cylinder.cap_dead_volume',
    'cylinder.rod_dead_volume', 'cylinder.stroke', 'cylinder.moving_mass',
    'friction.breakaway_force', 'friction.coulomb_force', 'friction.stribeck_velocity',
    'friction.stribeck_exponent', 'friction.viscous_coefficient',
    'friction.micro_viscous_coefficient', 'friction.film_velocity',
    'friction.film_time_acceleration', 'friction.film_time_deceleration',
    'friction.film_time_dwell', 'friction.fluid_time_constant', 'friction.dwell_exponent',
    'friction.dwell_coefficient', 'friction.stop_velocity', 'friction.start_velocity',
    'friction.film_rest_velocity', 'friction.memory_time',
    'valve.intake_coefficient', 'valve.exhaust_coefficient', 'valve.intake_voltage',
    'valve.exhaust_voltage', 'valve.exhaust_zero_voltage', 'valve.laminar_pressure_ratio',
    'gas.atmospheric_pressure',
    'gas.supply_temperature', 'gas.heat_capacity_ratio', 'gas.gas_constant',
    'operation.supply_pressure', 'operation.load_mass',
)  # fmt: skip
"""Numbers of the configuration, section.key, in the order of the constants below."""
(
    A1, A2, V10, V20, STROKE, MASS, F_S, F_C, V_S, N, SIGMA_2, SIGMA_1, V_B, TAU_P, TAU_M, TAU_0,
    T_FLUID, ALPHA, GAMMA, V_STOP, V_START, V_FILM, TAU_S, K_V1, K_V2, U_M, U_N, U_0, LAMINAR,
    P_ATM, T_S, KAPPA, R, P_S, LOAD, LAW, READING, FILM, FILM_REST,
) = range(len(CONSTANTS) + 4)  # fmt: skip

LAWS = ('coulomb_viscous', 'lugre', 'revised_lugre', 'revised_lugre_dwell')
READINGS = (
    'follows_clock', 'latched_at_breakaway', 'held_to_next_breakaway', 'fades_while_sliding',
)  # fmt: skip
FILMS = ('printed', 'normalised')
FILM_RESTS = ('with_dwell_clock', 'by_speed')

HIDDEN = (
    'supply_droop.resistance', 'cross_piston_leak.area', 'chamber_leak.area_1',
    'chamber_leak.area_2', 'valve_null_leak.intake_area', 'valve_null_leak.exhaust_area',
    'wall_heat_transfer.conductance_1', 'wall_heat_transfer.conductance_2',
    'line_lag.time_constant', 'valve_lag.time_constant', 'spool_hysteresis.width',
    'nonlinear_opening.intake_exponent', 'nonlinear_opening.exhaust_exponent',
    'pressure_dependent_friction.slope',
    'direction_dependent_friction.asymmetry', 'direction_dependent_friction.one_sidedness',
    'direction_dependent_viscous_friction.asymmetry',
    'direction_dependent_viscous_friction.one_sidedness', 'position_dependent_friction.gradient',
    'friction_warm_up.drop', 'friction_warm_up.work', 'inclination.angle',
    'load_spring.stiffness', 'load_spring.compression', 'end_cushion.length',
    'end_cushion.stiffness', 'end_cushion.damping', 'load_compliance.compliance',
    'load_compliance.damping', 'porous_leak.flow_1', 'porous_leak.flow_2',
    'porous_leak.exponent', 'natural_convection.conductance_1',
    'natural_convection.conductance_2', 'natural_convection.exponent',
    'pressure_power_friction.force', 'pressure_power_friction.exponent',
    'travel_dependent_friction.rate', 'travel_dependent_friction.limit',
    'time_dependent_friction.rate', 'time_dependent_friction.limit', 'bore_taper.taper',
    'line_resistance.resistance', 'spool_rate_limit.time_per_volt',
    'local_friction.share', 'local_friction.place', 'local_friction.width',
    'direction_dependent_static_friction.asymmetry',
    'direction_dependent_static_friction.one_sidedness',
    'forced_convection.coefficient', 'forced_convection.exponent', 'supply_tank.fall',
    'supply_tank.recovery_time', 'seal_elasticity.limit', 'seal_elasticity.reach',
    'local_piston_leak.area', 'local_piston_leak.place', 'local_piston_leak.width',
    'jet_convection.coefficient', 'jet_convection.decay_time', 'gas_mass_heat_transfer.rate',
)  # fmt: skip
"""What can be hidden in the equations, effect.parameter, in the order of the places below."""
(
    DROOP, CROSS, LEAK_1, LEAK_2, NULL_IN, NULL_OUT, HEAT_1, HEAT_2, LINE_TIME, LAG_TIME, PLAY,
    OPENING_IN, OPENING_OUT, SLOPE, ASYMMETRY, ONE_SIDE, DRAG, DRAG_ONE_SIDE, GRADIENT, DROP, WORK,
    ANGLE, SPRING, PRELOAD, CUSHION, CUSHION_K, CUSHION_D, COMPLIANCE, JOINT_D, PORES_1, PORES_2,
    PORES_POWER, CONVECTION_1, CONVECTION_2, CONVECTION_POWER, LIP, LIP_POWER, TRAVEL_RATE,
    TRAVEL_LIMIT, TIME_RATE, TIME_LIMIT, TAPER, LINE_DROP, VOLT_TIME,
    BELL, BELL_PLACE, BELL_WIDTH, STATIC_ASYMMETRY, STATIC_ONE_SIDE, FORCED, FORCED_POWER,
    TANK_FALL, TANK_TIME, SEAL_LIMIT, SEAL_REACH, WORN, WORN_PLACE, WORN_WIDTH, JET, JET_TIME,
    BY_GAS_MASS,
) = range(len(HIDDEN))  # fmt: skip
NONE_HIDDEN = {'nonlinear_opening.intake_exponent': 1.0,
               'nonlinear_opening.exhaust_exponent': 1.0, 'friction_warm_up.work': 1.0,
               'end_cushion.length': 0.01, 'porous_leak.exponent': 1.0,
               'natural_convection.exponent': 0.25, 'pressure_power_friction.exponent': 1.0,
               'travel_dependent_friction.limit': 0.5,
               'time_dependent_friction.limit': 0.5,
               'local_friction.width': 0.1, 'forced_convection.exponent': 0.8,
               'supply_tank.recovery_time': 1.0, 'seal_elasticity.reach': 3e-4,
               'local_piston_leak.width': 0.1, 'jet_convection.decay_time': 0.1}  # fmt: skip
"""Values with which an effect is absent, where they are not zero."""

FOREIGN, WIDTH = len(HIDDEN), 4
"""Where the numbers of foreign forms begin, if there are any; four for each slot: the code of the
form, 0 for none, its strength and two numbers of its shape. See ``foreign``."""
SLOTS = ('heat', 'leak', 'cross_leak', 'null_leak', 'supply', 'curve', 'spool', 'play', 'line',
         'gas_law', 'pressure', 'position', 'warming', 'side', 'bristle', 'shape', 'dwell',
         'film', 'load', 'pad', 'joint', 'viscous', 'stop')  # fmt: skip
(
    AT_HEAT, AT_LEAK, AT_CROSS, AT_NULL, AT_SUPPLY, AT_CURVE, AT_SPOOL, AT_PLAY, AT_LINE, AT_GAS,
    AT_PRESSURE, AT_POSITION, AT_WARMING, AT_SIDE, AT_BRISTLE, AT_SHAPE, AT_DWELL, AT_FILM,
    AT_LOAD, AT_PAD, AT_JOINT, AT_VISCOUS, AT_STOP,
) = range(FOREIGN, FOREIGN + WIDTH * len(SLOTS), WIDTH)  # fmt: skip
(
    CLOCK, WALL_1, WALL_2, SOURCE, SPOOL_V1, SPOOL_V2, PIPE_1, PIPE_2, ELEMENT_1, ELEMENT_2,
    ELEMENT_3, LATE, SWING, SWING_V, WAY,
) = range(STATES, STATES + 15)  # fmt: skip
"""More of the state where a form is foreign: time [s], walls [K], supply [Pa], velocities of the
spools [V/s], pressures in the lines [Pa], forces of elements [N], velocity that friction remembers
[m/s], deflection [m] and velocity [m/s] of a swinging load, way [m] or work [J] so far."""
FOREIGN_STATES = STATES + 15

SECOND_CODE = 20
"""Codes of the forms of the second list begin behind it, in the slots of the first."""
(
    STIRRED_1, STIRRED_2, SIDE_1, SIDE_2, COIL_1, COIL_2, HEATED, POCKET_1, POCKET_2,
) = range(FOREIGN_STATES, FOREIGN_STATES + 9)  # fmt: skip
"""Still more of it where a form is of the second list: motion of the gas [-], pressures in side
volumes [Pa], heat of coils and of friction [-], overpressures in the pockets of cushions [-]."""
SECOND_STATES = FOREIGN_STATES + 9
