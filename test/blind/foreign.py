"""
Forms that the library does not have: the laws of ``foreign_gas``, ``_force`` and ``_sensors``.

Each has one strength, zero where it is absent, that is drawn between a weak and a strong value of
the cylinder (``foreign_strengths``), and up to two numbers of its shape that are drawn too.
"""

from collections.abc import Mapping
from typing import NamedTuple

from . import foreign_force as force
from . import foreign_gas as gas

Range = tuple[float, float]


class Form(NamedTuple):
    """
    A law.

    :param mechanism: effects of the library, or parameters, that are the same physics; none where
        the library has no such physics
    :param slot: where its numbers are, see ``constants.SLOTS``; '' for a sensor's
    :param shape: further numbers -> range
    :param base: friction law of both the truth and the model, '' for the shipped one
    :param also: another slot and code that have the same strength
    :param balance: gas, force or sensor
    """

    mechanism: tuple[str, ...]
    slot: str
    code: int
    reference: str
    shape: Mapping[str, Range] = {}
    base: str = ''
    also: tuple[str, int] | None = None
    balance: str = ''


def balanced(
    gas: Mapping[str, Form], force: Mapping[str, Form], sensor: Mapping[str, Form]
) -> dict[str, Form]:
    """Return all forms, each with its balance."""
    return {
        name: form._replace(balance=balance)
        for balance, forms in (('gas', gas), ('force', force), ('sensor', sensor))
        for name, form in forms.items()
    }


HEAT = (
    'wall_heat_transfer',
    'natural_convection',
    'forced_convection',
    'jet_convection',
    'gas_mass_heat_transfer',
)
DROOP, CURVE = ('supply_droop', 'supply_tank'), ('nonlinear_opening',)
LEAK = 'chamber_leak', 'porous_leak'
CROSS, NULL = ('cross_piston_leak', 'local_piston_leak'), ('valve_null_leak',)
LAG = 'valve_lag', 'spool_rate_limit'
PLAY, LINE = ('spool_hysteresis',), ('line_lag', 'line_resistance')
PRESSURE = 'pressure_dependent_friction', 'pressure_power_friction'
SIDE = (
    'direction_dependent_friction',
    'direction_dependent_viscous_friction',
    'direction_dependent_static_friction',
)
PLACE = 'position_dependent_friction', 'local_friction'
WARM = 'friction_warm_up', 'travel_dependent_friction', 'time_dependent_friction'
SPRING, CUSHION, JOINT = ('load_spring',), ('end_cushion',), ('load_compliance',)
BRISTLES, STRIBECK = ('presliding_hysteresis', 'seal_elasticity'), ('stribeck',)
DWELL = 'dwell_static_friction', 'static_friction_recovery'  # so called up to 3512145
FILM = ('film_dynamics',)
NONE: tuple[str, ...] = ()
CRITICAL, PART = (0.15, 0.5), (0.2, 0.9)

GAS = {
    'woschni_heat': Form(HEAT, 'heat', gas.WOSCHNI, 'Woschni, SAE 670931, 1967'),
    'eichelberg_heat': Form(HEAT, 'heat', gas.EICHELBERG, 'Eichelberg, Engineering 148, 1939'),
    'laminar_convection': Form(HEAT, 'heat', gas.LAMINAR_CONVECTION,
        'McAdams, Heat Transmission, 1954'),
    'turbulent_convection': Form(HEAT, 'heat', gas.TURBULENT_CONVECTION,
        'McAdams, Heat Transmission, 1954'),
    'stirred_gas_heat': Form(HEAT, 'heat', gas.BY_MASS, 'Kagawa, J. Dyn. Sys. 107, 1985'),
    'thin_wall_heat': Form(HEAT, 'heat', gas.THIN_WALL,
        'Incropera and DeWitt, Fundamentals of Heat and Mass Transfer, lumped wall',
        {'capacity': (100.0, 600.0), 'to_room': (3.0, 15.0)}),
    'laminar_seal_leak': Form(LEAK, 'leak', gas.LAMINAR_GAP,
        'Blackburn, Fluid Power Control, 1960', {'critical': CRITICAL, 'first': PART}),
    'sonic_seal_leak': Form(LEAK, 'leak', gas.SONIC, 'ISO 6358-1:2013',
        {'critical': CRITICAL, 'first': PART}),
    'linear_seal_leak': Form(LEAK, 'leak', gas.LINEAR, 'Beater, Pneumatic Drives, 2007',
        {'critical': CRITICAL, 'first': PART}),
    'porous_seal_leak': Form(LEAK, 'leak', gas.POROUS,
        'Forchheimer 1901; Beavers and Sparrow 1969', {'power': (0.5, 1.8), 'first': PART}),
    'laminar_piston_gap': Form(CROSS, 'cross_leak', gas.LAMINAR_GAP,
        'Blackburn, Fluid Power Control, 1960'),
    'sonic_piston_leak': Form(CROSS, 'cross_leak', gas.SONIC, 'ISO 6358-1:2013',
        {'critical': CRITICAL}),
    'linear_piston_leak': Form(CROSS, 'cross_leak', gas.LINEAR, 'Beater, Pneumatic Drives, 2007'),
    'labyrinth_piston_leak': Form(CROSS, 'cross_leak', gas.LABYRINTH,
        'Egli, Trans. ASME 57, 1935'),
    'worn_bore_leak': Form(CROSS, 'cross_leak', gas.WORN_BORE, 'ISO 10099, leakage of worn tubes',
        {'place': (0.3, 0.7)}),
    'laminar_land_gap': Form(NULL, 'null_leak', gas.LAMINAR_GAP,
        'Merritt, Hydraulic Control Systems, 1967', {'critical': CRITICAL, 'exhaust': (1.0, 3.0)}),
    'sonic_land_leak': Form(NULL, 'null_leak', gas.SONIC, 'ISO 6358-1:2013',
        {'critical': CRITICAL, 'exhaust': (1.0, 3.0)}),
    'linear_land_leak': Form(NULL, 'null_leak', gas.LINEAR, 'Beater, Pneumatic Drives, 2007',
        {'critical': CRITICAL, 'exhaust': (1.0, 3.0)}),
    'rounded_land_leak': Form(NULL, 'null_leak', gas.ROUNDED_LAND,
        'Merritt, Hydraulic Control Systems, 1967', {'critical': CRITICAL, 'exhaust': (1.0, 3.0)}),
    'quadratic_droop': Form(DROOP, 'supply', gas.QUADRATIC_DROP,
        'Idelchik, Handbook of Hydraulic Resistance'),
    'small_tank': Form(DROOP, 'supply', gas.TANK, 'Andersen, Pneumatic Systems, 1967',
        {'feed': (3e-10, 2e-9)}),
    'slow_regulator': Form(DROOP, 'supply', gas.REGULATOR, 'Andersen, Pneumatic Systems, 1967',
        {'time': (0.1, 0.8)}),
    'compressor_pulsation': Form(NONE, 'supply', gas.PULSATION,
        'Bloch and Hoefner, Reciprocating Compressors', {'frequency': (2.0, 7.0)}),
    'compressor_switching': Form(NONE, 'supply', gas.SAWTOOTH, 'ISO 1217, load and unload control',
        {'period': (3.0, 9.0)}),
    # the share of the travel is 0.06 in a slow stroke and 0.6 in a fast one
    'quadratic_opening': Form(CURVE, 'curve', gas.QUADRATIC,
        'Beater, Pneumatic Drives, 2007, ch. 5'),
    'cubic_opening': Form(CURVE, 'curve', gas.CUBIC, 'Beater, Pneumatic Drives, 2007, ch. 5'),
    'two_slope_opening': Form(CURVE, 'curve', gas.KNEE, 'Valve data sheets: two gains',
        {'knee': (0.03, 0.12)}),
    'saturating_opening': Form(CURVE, 'curve', gas.SATURATING,
        'Beater, Pneumatic Drives, 2007, ch. 5'),
    'bent_exhaust_edge': Form(CURVE, 'curve', gas.ONE_EDGE,
        'Merritt, Hydraulic Control Systems, 1967'),
    'wider_dead_band': Form((*CURVE, 'valve.intake_voltage', 'valve.exhaust_voltage'), 'curve',
        gas.DEAD_BAND, 'Merritt 1967: overlap'),
    'discharge_by_ratio': Form(NONE, 'curve', gas.DISCHARGE, 'Perry, Trans. ASME 71, 1949'),
    'second_order_spool': Form(LAG, 'spool', gas.SECOND_ORDER,
        'Merritt, Hydraulic Control Systems, 1967', {'damping': (0.3, 1.2)}),
    'slewing_spool': Form(LAG, 'spool', gas.RATE_LIMIT,
        'Merritt 1967: saturated torque motor, time for 1 V'),
    'slow_closing_spool': Form(LAG, 'spool', gas.SLOW_CLOSING, 'Merritt 1967: spring against coil',
        {'opening': (0.1, 0.5)}),
    'valve_dead_time': Form((*LAG, *LINE), 'play', gas.DEAD_TIME, 'ISO 12238:2001, shifting time'),
    'preisach_spool': Form(PLAY, 'play', gas.PREISACH,
        'Mayergoyz, Mathematical Models of Hysteresis, 1991'),
    'sticking_spool': Form(PLAY, 'play', gas.STICTION,
        'Choudhury et al., Control Eng. Practice 13, 2005'),
    'one_flank_play': Form(PLAY, 'play', gas.ONE_FLANK,
        'Tao and Kokotovic, Adaptive Control with Actuator Nonlinearities, 1996'),
    'magnetic_loop': Form(PLAY, 'play', gas.MAGNETIC,
        'Coleman and Hodgdon, Arch. Rat. Mech. 99, 1987', {'travel': (0.05, 0.5)}),
    'drifting_spool': Form(NONE, 'spool', gas.SPOOL_DRIFT, 'IEC 61298-3: drift with temperature'),
    'line_volume': Form(LINE, 'line', gas.PIPE, 'Richer and Hurmuzlu, J. Dyn. Sys. 122, 2000',
        {'conductance': (2e-8, 6e-8)}),
    'line_orifice': Form((*LINE, *CURVE), 'line', gas.LINE_ORIFICE,
        'Andersen 1967: openings in series'),
    'line_resonance': Form(LINE, 'line', gas.HELMHOLTZ,
        'Stecki and Davis, Fluid transmission lines, 1986',
        {'conductance': (2e-8, 6e-8), 'area_by_length': (8e-6, 3e-5)}),
    'delay_and_lag': Form((*LINE, *LAG), 'play', gas.DELAY_AND_LAG,
        'Richer and Hurmuzlu 2000: delay and attenuation', also=('line', gas.LINE_LAG)),
    'drying_gas': Form(NONE, 'gas_law', gas.DRYING, 'ISO 8778; Beater 2007: moist air',
        {'time': (3.0, 8.0)}),
    'elastic_hose': Form(NONE, 'gas_law', gas.ELASTIC_HOSE, 'Beater 2007, compliance of hoses'),
    'opening_seal_leak': Form(NONE, 'leak', gas.OPENING_SEAL,
        'ISO 10099: leakage that grows in operation', {'critical': CRITICAL, 'first': PART}),
    'relief_valve': Form(NONE, 'leak', gas.RELIEF, 'ISO 4126: spring-loaded poppet',
        {'opens': (2.5e5, 3.2e5), 'first': PART}),
}  # fmt: skip
FORCE = {
    'power_law_seal': Form(PRESSURE, 'pressure', force.POWER_OF_PRESSURE,
        'Belforte et al., J. Fluid Control 20, 1989', {'power': (0.4, 1.8)}),
    'first_lip_seal': Form(PRESSURE, 'pressure', force.FIRST_LIP,
        'Raparelli et al., Tribology Int. 30, 1997'),
    'second_lip_seal': Form(PRESSURE, 'pressure', force.SECOND_LIP,
        'Raparelli et al., Tribology Int. 30, 1997'),
    'difference_seal': Form(PRESSURE, 'pressure', force.DIFFERENCE,
        'Andrighetto et al., ABCM Mechatronics 2, 2006'),
    'pressed_oil': Form((*PRESSURE, 'friction.viscous_coefficient'), 'viscous', force.THICK_OIL,
        'Barus, Am. J. Science 45, 1893'),
    'bump_at_place': Form(PLACE, 'position', force.BUMP,
        'Armstrong-Helouvry, Control of Machines with Friction, 1991',
        {'place': (0.3, 0.7), 'width': (0.08, 0.25)}),
    'tapered_tube': Form(PLACE, 'position', force.TAPER, 'Armstrong-Helouvry 1991'),
    'joined_sleeve': Form(PLACE, 'position', force.SLEEVE, 'Armstrong-Helouvry 1991',
        {'place': (0.3, 0.7)}),
    'long_wave_bore': Form(PLACE, 'position', force.LONG_WAVE, 'ISO 4394: straightness of tubes',
        {'waves': (0.7, 1.6)}),
    'short_wave_bore': Form(NONE, 'position', force.SHORT_WAVE,
        'ISO 4394: waviness of honed tubes', {'waves': (10.0, 24.0)}),
    'sticking_place': Form(NONE, 'position', force.STICKING_PLACE,
        'Armstrong-Helouvry 1991: a score in the bore', {'place': (0.35, 0.65)}),
    'warming_by_time': Form(WARM, 'warming', force.BY_TIME, 'Simoni et al., IROS 2015',
        {'time': (2.0, 8.0)}),
    'warming_by_distance': Form(WARM, 'warming', force.BY_DISTANCE,
        'Archard, J. Appl. Phys. 24, 1953: running in', {'distance': (0.1, 0.5)}),
    'rising_with_work': Form(WARM, 'warming', force.RISING,
        'Armstrong-Helouvry 1991: lubricant that is lost', {'work': (0.5, 2.0)}),
    'thinning_oil': Form((*WARM, 'friction.viscous_coefficient'), 'viscous', force.THINNING_OIL,
        'Vogel, Phys. Z. 22, 1921', {'distance': (0.1, 0.5)}),
    'wearing_friction': Form(NONE, 'warming', force.WEAR,
        'Karhunen-Loeve series of a Brownian motion', {'walk': (1.0, 100.0)}),
    'outward_level': Form(SIDE, 'side', force.OUTWARD_LEVEL,
        'Canudas de Wit et al., IEEE TAC 40, 1995'),
    'outward_excess': Form((*SIDE, *STRIBECK), 'side', force.OUTWARD_EXCESS,
        'Armstrong-Helouvry 1991: asymmetric Stribeck curve'),
    'outward_viscous': Form(SIDE, 'side', force.OUTWARD_VISCOUS, 'Armstrong-Helouvry 1991'),
    'inward_force': Form(SIDE, 'side', force.INWARD_FORCE,
        'Raparelli et al. 1997: wiper of the rod'),
    'dahl_bristles': Form((*BRISTLES, 'friction.element_stiffness'), 'bristle', force.DAHL,
        'Dahl, Aerospace TOR-0158, 1968'),
    'elasto_plastic_bristles': Form((*BRISTLES, 'friction.element_stiffness'), 'bristle',
        force.ELASTO_PLASTIC, 'Dupont et al., IEEE TAC 47, 2002'),
    'maxwell_slip': Form(BRISTLES, 'bristle', force.MAXWELL_SLIP,
        'Al-Bender et al., IEEE TAC 50, 2005', {'bend': (1e-4, 6e-4)}),
    'tustin_curve': Form(STRIBECK, 'shape', force.TUSTIN, 'Tustin, J. IEE 94, 1947',
        {'speed': (0.7, 2.0)}, base='coulomb_viscous'),
    'lorentz_curve': Form(STRIBECK, 'shape', force.LORENTZ,
        'Hess and Soom, J. Tribology 112, 1990', {'speed': (0.7, 2.0)}, base='coulomb_viscous'),
    'hyperbolic_curve': Form(STRIBECK, 'shape', force.HESS_SOOM, 'Hess and Soom 1990',
        {'speed': (0.7, 2.0)}, base='coulomb_viscous'),
    'bo_pavelescu_curve': Form(STRIBECK, 'shape', force.BO_PAVELESCU,
        'Bo and Pavelescu, Wear 82, 1982', {'speed': (0.7, 2.0), 'power': (0.5, 1.0)},
        base='coulomb_viscous'),
    'logarithmic_dwell': Form(DWELL, 'dwell', force.LOGARITHMIC,
        'Rabinowicz 1958; Dieterich, J. Geophys. Res. 77, 1972', {'time': (0.01, 1.0)},
        base='revised_lugre'),
    'power_law_dwell': Form(DWELL, 'dwell', force.POWER_OF_DWELL,
        'Brockley and Davis, J. Lubrication Tech. 90, 1968', {'power': (0.08, 0.3)},
        base='revised_lugre'),
    'rational_dwell': Form(DWELL, 'dwell', force.RATIONAL,
        'Kato, Sato and Matsubayashi, J. Lubrication Tech. 94, 1972', {'time': (0.5, 6.0)},
        base='revised_lugre'),
    'linear_film': Form(FILM, 'film', force.LINEAR_FILM,
        'Hamrock, Fundamentals of Fluid Film Lubrication', {'time': (0.02, 0.5)}, base='lugre'),
    'film_by_distance': Form(FILM, 'film', force.FILM_BY_DISTANCE,
        'Polycarpou and Soom, J. Tribology 117, 1995', {'distance': (0.001, 0.02)}, base='lugre'),
    'progressive_spring': Form(SPRING, 'load', force.PROGRESSIVE,
        'Wahl, Mechanical Springs, 1963'),
    'spring_behind_gap': Form(SPRING, 'load', force.DEAD_ZONE,
        'Nayfeh and Mook, Nonlinear Oscillations, 1979', {'gap': (0.2, 0.5)}),
    'gas_spring': Form(SPRING, 'load', force.GAS_SPRING, 'Beater 2007: polytropic gas spring'),
    'eccentric_weight': Form(('inclination', *SPRING), 'load', force.ECCENTRIC, 'Crank and weight',
        {'turns': (0.15, 0.5)}),
    'curved_rail': Form(('inclination', *SPRING), 'load', force.CURVED_RAIL,
        'Timoshenko: rail that sags'),
    'detent': Form(NONE, 'load', force.DETENT, 'Gieras, Permanent Magnet Motors: cogging',
        {'period': (0.006, 0.02)}),
    'shaking_floor': Form(NONE, 'load', force.SHAKING_FLOOR, 'ISO 10816: vibration of foundations',
        {'frequency': (1.5, 6.0)}),
    'sloshing_load': Form(NONE, 'load', force.SLOSHING, 'Ibrahim, Liquid Sloshing Dynamics, 2005'),
    'churning': Form(NONE, 'viscous', force.CHURNING, 'Turbulent drag, Schlichting'),
    'late_friction': Form(NONE, 'viscous', force.MEMORY,
        'Hess and Soom, J. Tribology 112, 1990: memory', {'time': (0.02, 0.15)}),
    'air_cushion_orifice': Form(CUSHION, 'pad', force.AIR_ORIFICE,
        'Beater 2007: pneumatic cushioning', {'length': (0.008, 0.02)}),
    'trapped_air_cushion': Form(CUSHION, 'pad', force.TRAPPED_AIR,
        'Beater 2007: adiabatic cushion', {'length': (0.008, 0.02)}),
    'rubber_bumper': Form(CUSHION, 'pad', force.RUBBER,
        'Hunt and Crossley, J. Appl. Mech. 42, 1975',
        {'length': (0.006, 0.015), 'damping': (0.5, 3.0)}),
    'joint_with_play': Form(JOINT, 'joint', force.BACKLASH,
        'Nordin and Gutman, Automatica 38, 2002', {'play': (2e-4, 2e-3)}),
    'hardening_joint': Form(JOINT, 'joint', force.HARDENING, 'Duffing 1918; Nayfeh and Mook 1979',
        {'scale': (5e-4, 3e-3)}),
    'creeping_stop': Form(NONE, 'stop', force.CREEPING_STOP,
        'Findley, Creep of Nonlinear Viscoelastic Materials, 1976'),
}  # fmt: skip
SENSOR = {
    'bowed_position': Form(('position_scale',), '', 0, 'IEC 61298-2: terminal-based linearity'),
    'drifting_position': Form(NONE, '', 0, 'IEC 61298-2: drift'),
    'position_play': Form(NONE, '', 0, 'IEC 60393: backlash of potentiometers'),
    'two_pole_position_lag': Form(('sensor_delay',), '', 0, 'Doebelin, Measurement Systems'),
    'drifting_pressure_zero': Form(('pressure_offset',), '', 0, 'IEC 61298-2: drift'),
    'warming_pressure_zero': Form(('pressure_offset',), '', 0,
        'IEC 61298-3: zero over temperature', {'time': (2.0, 8.0)}),
    'bowed_pressure': Form(('pressure_offset',), '', 0, 'IEC 61298-2: terminal-based linearity'),
    'slow_pressure_sensor': Form(NONE, '', 0, 'Doebelin, Measurement Systems: tubing'),
}  # fmt: skip
FORMS = balanced(GAS, FORCE, SENSOR)
"""Name -> form."""
KNOWN = tuple(name for name, form in FORMS.items() if form.mechanism)
UNKNOWN = tuple(name for name, form in FORMS.items() if not form.mechanism)
NEVER_WEAK = ('line_volume', 'line_resonance')
"""Forms that do not vanish with their strength, a volume: their pressure drop stays."""
