"""
Forms that the library does not have: the laws of ``foreign_gas``, ``_force`` and ``_sensors``.

Each has one strength, zero where it is absent, that is drawn between a weak and a strong value of
the cylinder, and up to two numbers of its shape that are drawn too.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from . import constants as at
from . import foreign_force as force
from . import foreign_gas as gas

Range = tuple[float, float]
CYLINDERS = 3


class Form(NamedTuple):
    """
    A law.

    :param mechanism: effects of the library, or parameters, that are the same physics; none where
        the library has no such physics
    :param balance: gas, force or sensor
    :param slot: where its numbers are, see ``constants.SLOTS``; '' for a sensor's
    :param strengths: weak and strong, for each cylinder [SI]
    :param shape: further numbers -> range
    :param base: friction law of both the truth and the model, '' for the shipped one
    :param also: another slot and code that have the same strength
    """

    mechanism: tuple[str, ...]
    balance: str
    slot: str
    code: int
    strengths: tuple[Range, ...]
    reference: str
    shape: Mapping[str, Range] = {}
    base: str = ''
    also: tuple[str, int] | None = None


def same(weak: float, strong: float) -> tuple[Range, ...]:
    """Return one range of strengths for all cylinders."""
    return ((weak, strong),) * CYLINDERS


def sized(weak: float, strong: float, *sizes: float) -> tuple[Range, ...]:
    """Return a range of strengths for each cylinder, in proportion to a size of it."""
    return tuple((weak * size, strong * size) for size in sizes)


def _leaks(weak: float, strong: float) -> tuple[Range, ...]:
    return sized(weak, strong, 1.0, 1.5, 2.5)  # the cylinders' volumes and flows grow so


def _friction(weak: float, strong: float) -> tuple[Range, ...]:
    return sized(weak, strong, 0.6, 1.0, 1.3)  # and their seals


HEAT, DROOP, CURVE = ('wall_heat_transfer',), ('supply_droop',), ('nonlinear_opening',)
LEAK, CROSS, NULL = ('chamber_leak',), ('cross_piston_leak',), ('valve_null_leak',)
LAG, PLAY, LINE = ('valve_lag',), ('spool_hysteresis',), ('line_lag',)
PRESSURE, SIDE = ('pressure_dependent_friction',), ('direction_dependent_friction',)
PLACE, WARM = ('position_dependent_friction',), ('friction_warm_up',)
SPRING, CUSHION, JOINT = ('load_spring',), ('end_cushion',), ('load_compliance',)
BRISTLES, STRIBECK = ('presliding_hysteresis',), ('stribeck',)
DWELL, FILM = ('dwell_static_friction',), ('film_dynamics',)
NONE: tuple[str, ...] = ()
CRITICAL, PART = (0.15, 0.5), (0.2, 0.9)

# Strengths change a pressure, a force or a place by some 3 to 60 times the noise of its sensor
# (150 Pa, 2e-5 m) in the experiments. Flows of 2e-5 (slow) to 1.4e-4 kg/s (fast) fill the
# chambers, walls of 0.02 to 0.06 m^2 hold them; 2 to 6 bar are across a seal, 4 to 26 N of
# friction in it.
GAS: dict[str, Form] = {
    'woschni_heat': Form(HEAT, 'gas', 'heat', gas.WOSCHNI, same(6.0, 60.0),
        'Woschni, SAE 670931, 1967'),
    'eichelberg_heat': Form(HEAT, 'gas', 'heat', gas.EICHELBERG, same(6.0, 60.0),
        'Eichelberg, Engineering 148, 1939'),
    'laminar_convection': Form(HEAT, 'gas', 'heat', gas.LAMINAR_CONVECTION, same(3.0, 30.0),
        'McAdams, Heat Transmission, 1954'),
    'turbulent_convection': Form(HEAT, 'gas', 'heat', gas.TURBULENT_CONVECTION, same(2.5, 25.0),
        'McAdams, Heat Transmission, 1954'),
    'stirred_gas_heat': Form(HEAT, 'gas', 'heat', gas.BY_MASS, same(300.0, 3000.0),
        'Kagawa, JFPS 16, 1985'),
    'thin_wall_heat': Form(HEAT, 'gas', 'heat', gas.THIN_WALL, same(8.0, 60.0),
        'Incropera and DeWitt, Fundamentals of Heat and Mass Transfer, lumped wall',
        {'capacity': (100.0, 600.0), 'to_room': (3.0, 15.0)}),
    # 1e-7 to 2e-6 kg/s over 2 bar
    'laminar_seal_leak': Form(LEAK, 'gas', 'leak', gas.LAMINAR_GAP, _leaks(2e-18, 3e-17),
        'Blackburn, Fluid Power Control, 1960', {'critical': CRITICAL, 'first': PART}),
    'sonic_seal_leak': Form(LEAK, 'gas', 'leak', gas.SONIC, _leaks(1e-12, 1.5e-11),
        'ISO 6358-1:2013', {'critical': CRITICAL, 'first': PART}),
    'linear_seal_leak': Form(LEAK, 'gas', 'leak', gas.LINEAR, _leaks(1e-12, 1.5e-11),
        'Beater, Pneumatic Drives, 2007', {'critical': CRITICAL, 'first': PART}),
    'porous_seal_leak': Form(LEAK, 'gas', 'leak', gas.POROUS, _leaks(1e-12, 1.5e-11),
        'Forchheimer 1901; Beavers and Sparrow 1969', {'power': (0.5, 1.8), 'first': PART}),
    'laminar_piston_gap': Form(CROSS, 'gas', 'cross_leak', gas.LAMINAR_GAP, _leaks(2e-18, 3e-17),
        'Blackburn, Fluid Power Control, 1960'),
    'sonic_piston_leak': Form(CROSS, 'gas', 'cross_leak', gas.SONIC, _leaks(2e-12, 3e-11),
        'ISO 6358-1:2013', {'critical': CRITICAL}),
    'linear_piston_leak': Form(CROSS, 'gas', 'cross_leak', gas.LINEAR, _leaks(2e-12, 3e-11),
        'Beater, Pneumatic Drives, 2007'),
    'labyrinth_piston_leak': Form(CROSS, 'gas', 'cross_leak', gas.LABYRINTH, _leaks(1e-12, 2e-11),
        'Egli, Trans. ASME 57, 1935'),
    'worn_bore_leak': Form(CROSS, 'gas', 'cross_leak', gas.WORN_BORE, _leaks(8e-12, 8e-11),
        'ISO 10099, leakage of worn tubes', {'place': (0.3, 0.7)}),
    'laminar_land_gap': Form(NULL, 'gas', 'null_leak', gas.LAMINAR_GAP, same(2e-18, 2e-17),
        'Merritt, Hydraulic Control Systems, 1967',
        {'critical': CRITICAL, 'exhaust': (1.0, 3.0)}),
    'sonic_land_leak': Form(NULL, 'gas', 'null_leak', gas.SONIC, same(5e-13, 6e-12),
        'ISO 6358-1:2013', {'critical': CRITICAL, 'exhaust': (1.0, 3.0)}),
    'linear_land_leak': Form(NULL, 'gas', 'null_leak', gas.LINEAR, same(5e-13, 6e-12),
        'Beater, Pneumatic Drives, 2007', {'critical': CRITICAL, 'exhaust': (1.0, 3.0)}),
    'rounded_land_leak': Form(NULL, 'gas', 'null_leak', gas.ROUNDED_LAND, same(8e-13, 1e-11),
        'Merritt, Hydraulic Control Systems, 1967',
        {'critical': CRITICAL, 'exhaust': (1.0, 3.0)}),
    # 5 to 60 kPa at 1e-4 kg/s
    'quadratic_droop': Form(DROOP, 'gas', 'supply', gas.QUADRATIC_DROP, same(1e12, 1.2e13),
        'Idelchik, Handbook of Hydraulic Resistance'),
    'small_tank': Form(DROOP, 'gas', 'supply', gas.TANK, same(1e7, 2e8),
        'Andersen, Pneumatic Systems, 1967: 0.6 to 12 litres', {'feed': (3e-10, 2e-9)}),
    'slow_regulator': Form(DROOP, 'gas', 'supply', gas.REGULATOR, same(2e8, 1.5e9),
        'Andersen, Pneumatic Systems, 1967', {'time': (0.1, 0.8)}),
    'compressor_pulsation': Form(NONE, 'gas', 'supply', gas.PULSATION, same(4e3, 4e4),
        'Bloch and Hoefner, Reciprocating Compressors', {'frequency': (2.0, 7.0)}),
    'compressor_switching': Form(NONE, 'gas', 'supply', gas.SAWTOOTH, same(8e3, 6e4),
        'ISO 1217, load and unload control', {'period': (3.0, 9.0)}),
    # the share of the travel is 0.06 in a slow stroke and 0.6 in a fast one
    'quadratic_opening': Form(CURVE, 'gas', 'curve', gas.QUADRATIC, same(0.03, 0.4),
        'Beater, Pneumatic Drives, 2007, ch. 5'),
    'cubic_opening': Form(CURVE, 'gas', 'curve', gas.CUBIC, same(0.03, 0.4),
        'Beater, Pneumatic Drives, 2007, ch. 5'),
    'two_slope_opening': Form(CURVE, 'gas', 'curve', gas.KNEE, same(0.04, 0.5),
        'Valve data sheets: two gains', {'knee': (0.03, 0.12)}),
    'saturating_opening': Form(CURVE, 'gas', 'curve', gas.SATURATING, same(0.3, 4.0),
        'Beater, Pneumatic Drives, 2007, ch. 5'),
    'bent_exhaust_edge': Form(CURVE, 'gas', 'curve', gas.ONE_EDGE, same(0.1, 0.8),
        'Merritt, Hydraulic Control Systems, 1967'),
    'wider_dead_band': Form((*CURVE, 'valve.intake_voltage', 'valve.exhaust_voltage'), 'gas',
        'curve', gas.DEAD_BAND, same(0.002, 0.02), 'Merritt 1967: overlap'),
    'discharge_by_ratio': Form(NONE, 'gas', 'curve', gas.DISCHARGE, same(0.03, 0.3),
        'Perry, Trans. ASME 71, 1949'),
    'second_order_spool': Form(LAG, 'gas', 'spool', gas.SECOND_ORDER, same(0.006, 0.04),
        'Merritt, Hydraulic Control Systems, 1967', {'damping': (0.3, 1.2)}),
    'slewing_spool': Form(LAG, 'gas', 'spool', gas.RATE_LIMIT, same(0.03, 0.4),
        'Merritt 1967: saturated torque motor, time for 1 V'),
    'slow_closing_spool': Form(LAG, 'gas', 'spool', gas.SLOW_CLOSING, same(0.01, 0.08),
        'Braun et al., Pneumatic solenoid valves, 2011', {'opening': (0.1, 0.5)}),
    'valve_dead_time': Form((*LAG, *LINE), 'gas', 'play', gas.DEAD_TIME, same(0.006, 0.05),
        'ISO 12238:2001, shifting time'),
    'preisach_spool': Form(PLAY, 'gas', 'play', gas.PREISACH, same(0.01, 0.08),
        'Mayergoyz, Mathematical Models of Hysteresis, 1991'),
    'sticking_spool': Form(PLAY, 'gas', 'play', gas.STICTION, same(0.05, 0.2),
        'Choudhury et al., Control Eng. Practice 13, 2005'),
    'one_flank_play': Form(PLAY, 'gas', 'play', gas.ONE_FLANK, same(0.01, 0.07),
        'Tao and Kokotovic, Adaptive Control with Actuator Nonlinearities, 1996'),
    'magnetic_loop': Form(PLAY, 'gas', 'play', gas.MAGNETIC, same(0.004, 0.04),
        'Coleman and Hodgdon, Arch. Rat. Mech. 99, 1987', {'travel': (0.05, 0.5)}),
    'drifting_spool': Form(NONE, 'gas', 'spool', gas.SPOOL_DRIFT, same(0.004, 0.04),
        'IEC 61298-3: drift with temperature'),
    'line_volume': Form(LINE, 'gas', 'line', gas.PIPE, same(3e-6, 4e-5),
        'Richer and Hurmuzlu, J. Dyn. Sys. 122, 2000', {'conductance': (2e-8, 6e-8)}),
    'line_orifice': Form((*LINE, *CURVE), 'gas', 'line', gas.LINE_ORIFICE, same(5e6, 5e7),
        'Andersen 1967: openings in series'),
    'line_resonance': Form(LINE, 'gas', 'line', gas.HELMHOLTZ, same(3e-6, 3e-5),
        'Stecki and Davis, Fluid transmission lines, 1986',
        {'conductance': (2e-8, 6e-8), 'area_by_length': (8e-6, 3e-5)}),
    'delay_and_lag': Form((*LINE, *LAG), 'gas', 'play', gas.DELAY_AND_LAG, same(0.004, 0.03),
        'Richer and Hurmuzlu 2000: delay and attenuation', also=('line', gas.LINE_LAG)),
    'drying_gas': Form(NONE, 'gas', 'gas_law', gas.DRYING, same(0.01, 0.1),
        'ISO 8778; Beater 2007: moist air', {'time': (3.0, 8.0)}),
    'elastic_hose': Form(NONE, 'gas', 'gas_law', gas.ELASTIC_HOSE, same(3e-13, 5e-12),
        'Beater 2007, compliance of hoses'),
    'opening_seal_leak': Form(NONE, 'gas', 'leak', gas.OPENING_SEAL, _leaks(3e-12, 3e-11),
        'ISO 10099: leakage that grows in operation', {'critical': CRITICAL, 'first': PART}),
    'relief_valve': Form(NONE, 'gas', 'leak', gas.RELIEF, _leaks(5e-12, 6e-11),
        'ISO 4126: spring-loaded poppet', {'opens': (2.5e5, 3.2e5), 'first': PART}),
}  # fmt: skip
FORCE: dict[str, Form] = {
    'power_law_seal': Form(PRESSURE, 'force', 'pressure', force.POWER_OF_PRESSURE,
        _friction(0.4, 5.0), 'Belforte et al., Tribology Int. 26, 1993', {'power': (0.4, 1.8)}),
    'first_lip_seal': Form(PRESSURE, 'force', 'pressure', force.FIRST_LIP, _friction(0.3, 4.0),
        'Raparelli et al., Meccanica 32, 1997'),
    'second_lip_seal': Form(PRESSURE, 'force', 'pressure', force.SECOND_LIP, _friction(0.3, 4.0),
        'Raparelli et al., Meccanica 32, 1997'),
    'difference_seal': Form(PRESSURE, 'force', 'pressure', force.DIFFERENCE, _friction(0.4, 5.0),
        'Andrighetto et al., Mechatronics 16, 2006'),
    'pressed_oil': Form((*PRESSURE, 'friction.viscous_coefficient'), 'force', 'viscous',
        force.THICK_OIL, same(0.03, 0.3), 'Barus, Am. J. Science 45, 1893'),
    'bump_at_place': Form(PLACE, 'force', 'position', force.BUMP, same(0.1, 0.8),
        'Armstrong-Helouvry, Control of Machines with Friction, 1991',
        {'place': (0.3, 0.7), 'width': (0.08, 0.25)}),
    'tapered_tube': Form(PLACE, 'force', 'position', force.TAPER, same(0.1, 0.8),
        'Armstrong-Helouvry 1991'),
    'joined_sleeve': Form(PLACE, 'force', 'position', force.SLEEVE, same(0.08, 0.7),
        'Armstrong-Helouvry 1991', {'place': (0.3, 0.7)}),
    'long_wave_bore': Form(PLACE, 'force', 'position', force.LONG_WAVE, same(0.06, 0.5),
        'ISO 4394: straightness of tubes', {'waves': (0.7, 1.6)}),
    'short_wave_bore': Form(NONE, 'force', 'position', force.SHORT_WAVE, same(0.1, 0.7),
        'ISO 4394: waviness of honed tubes', {'waves': (10.0, 24.0)}),
    'sticking_place': Form(NONE, 'force', 'position', force.STICKING_PLACE, same(0.6, 4.0),
        'Armstrong-Helouvry 1991: a score in the bore', {'place': (0.35, 0.65)}),
    'warming_by_time': Form(WARM, 'force', 'warming', force.BY_TIME, same(0.08, 0.6),
        'Simoni et al., Control Eng. Practice 47, 2016', {'time': (2.0, 8.0)}),
    'warming_by_distance': Form(WARM, 'force', 'warming', force.BY_DISTANCE, same(0.1, 0.6),
        'Archard, J. Appl. Phys. 24, 1953: running in', {'distance': (0.1, 0.5)}),
    'rising_with_work': Form(WARM, 'force', 'warming', force.RISING, same(0.1, 0.8),
        'Blok 1937: starved lips', {'work': (0.5, 2.0)}),
    'thinning_oil': Form((*WARM, 'friction.viscous_coefficient'), 'force', 'viscous',
        force.THINNING_OIL, same(0.1, 0.7), 'Vogel, Phys. Z. 22, 1921', {'distance': (0.1, 0.5)}),
    'wearing_friction': Form(NONE, 'force', 'warming', force.WEAR, same(0.1, 0.6),
        'Karhunen-Loeve series of a Brownian motion', {'walk': (1.0, 100.0)}),
    'outward_level': Form(SIDE, 'force', 'side', force.OUTWARD_LEVEL, same(0.06, 0.5),
        'Canudas de Wit et al., IEEE TAC 40, 1995'),
    'outward_excess': Form((*SIDE, *STRIBECK), 'force', 'side', force.OUTWARD_EXCESS,
        same(0.08, 0.7), 'Armstrong-Helouvry 1991: asymmetric Stribeck curve'),
    'outward_viscous': Form(SIDE, 'force', 'side', force.OUTWARD_VISCOUS,
        sized(0.05, 0.6, 85.0, 210.0, 350.0), 'Armstrong-Helouvry 1991'),
    'inward_force': Form(SIDE, 'force', 'side', force.INWARD_FORCE, _friction(0.3, 4.0),
        'Raparelli et al. 1997: wiper of the rod'),
    'dahl_bristles': Form((*BRISTLES, 'friction.element_stiffness'), 'force', 'bristle',
        force.DAHL, same(0.5, 6.0), 'Dahl, Aerospace TOR-0158, 1968'),
    'elasto_plastic_bristles': Form((*BRISTLES, 'friction.element_stiffness'), 'force',
        'bristle', force.ELASTO_PLASTIC, same(0.4, 0.95), 'Dupont et al., IEEE TAC 47, 2002'),
    'maxwell_slip': Form(BRISTLES, 'force', 'bristle', force.MAXWELL_SLIP, same(0.1, 0.8),
        'Al-Bender et al., IEEE TAC 50, 2005', {'bend': (1e-4, 6e-4)}),
    'tustin_curve': Form(STRIBECK, 'force', 'shape', force.TUSTIN, _friction(0.5, 8.0),
        'Tustin, J. IEE 94, 1947', {'speed': (0.7, 2.0)}, base='coulomb_viscous'),
    'lorentz_curve': Form(STRIBECK, 'force', 'shape', force.LORENTZ, _friction(0.5, 8.0),
        'Hess and Soom, J. Tribology 112, 1990', {'speed': (0.7, 2.0)}, base='coulomb_viscous'),
    'hyperbolic_curve': Form(STRIBECK, 'force', 'shape', force.HESS_SOOM, _friction(0.5, 8.0),
        'Hess and Soom 1990', {'speed': (0.7, 2.0)}, base='coulomb_viscous'),
    'bo_pavelescu_curve': Form(STRIBECK, 'force', 'shape', force.BO_PAVELESCU,
        _friction(0.5, 8.0), 'Bo and Pavelescu, Wear 82, 1982',
        {'speed': (0.7, 2.0), 'power': (0.5, 1.0)}, base='coulomb_viscous'),
    'logarithmic_dwell': Form(DWELL, 'force', 'dwell', force.LOGARITHMIC, same(0.3, 1.0),
        'Rabinowicz 1958; Dieterich, J. Geophys. Res. 77, 1972', {'time': (0.01, 1.0)},
        base='revised_lugre'),
    'power_law_dwell': Form(DWELL, 'force', 'dwell', force.POWER_OF_DWELL, same(0.2, 1.0),
        'Brockley and Davis, J. Lubrication Tech. 90, 1968', {'power': (0.08, 0.3)},
        base='revised_lugre'),
    'rational_dwell': Form(DWELL, 'force', 'dwell', force.RATIONAL, same(0.2, 1.0),
        'Kato, Sato and Matsubayashi, J. Lubrication Tech. 94, 1972', {'time': (0.5, 6.0)},
        base='revised_lugre'),
    'linear_film': Form(FILM, 'force', 'film', force.LINEAR_FILM, same(0.2, 1.0),
        'Hamrock, Fundamentals of Fluid Film Lubrication', {'time': (0.02, 0.5)}, base='lugre'),
    'film_by_distance': Form(FILM, 'force', 'film', force.FILM_BY_DISTANCE, same(0.2, 1.0),
        'Polycarpou and Soom, J. Tribology 117, 1995', {'distance': (0.001, 0.02)},
        base='lugre'),
    # 0.45 to 6 kg move
    'progressive_spring': Form(SPRING, 'force', 'load', force.PROGRESSIVE,
        sized(20.0, 250.0, 0.5, 1.0, 1.5), 'Wahl, Mechanical Springs, 1963'),
    'spring_behind_gap': Form(SPRING, 'force', 'load', force.DEAD_ZONE,
        sized(15.0, 180.0, 0.5, 1.0, 1.5), 'Nayfeh and Mook, Nonlinear Oscillations, 1979',
        {'gap': (0.2, 0.5)}),
    'gas_spring': Form(SPRING, 'force', 'load', force.GAS_SPRING, _friction(0.3, 4.0),
        'Beater 2007: polytropic gas spring'),
    'eccentric_weight': Form(('inclination', *SPRING), 'force', 'load', force.ECCENTRIC,
        same(0.02, 0.2), 'Crank and weight', {'turns': (0.15, 0.5)}),
    'curved_rail': Form(('inclination', *SPRING), 'force', 'load', force.CURVED_RAIL,
        same(0.02, 0.2), 'Timoshenko: rail that sags'),
    'detent': Form(NONE, 'force', 'load', force.DETENT, _friction(0.3, 4.0),
        'Gieras, Permanent Magnet Motors: cogging', {'period': (0.006, 0.02)}),
    'shaking_floor': Form(NONE, 'force', 'load', force.SHAKING_FLOOR, same(0.3, 3.0),
        'ISO 10816: vibration of foundations', {'frequency': (1.5, 6.0)}),
    'sloshing_load': Form(NONE, 'force', 'load', force.SLOSHING, same(0.2, 1.5),
        'Ibrahim, Liquid Sloshing Dynamics, 2005'),
    'churning': Form(NONE, 'force', 'viscous', force.CHURNING,
        sized(0.4, 6.0, 85.0, 210.0, 350.0), 'Turbulent drag, Schlichting'),
    'late_friction': Form(NONE, 'force', 'viscous', force.MEMORY, same(0.15, 1.5),
        'Hess and Soom, J. Tribology 112, 1990: memory', {'time': (0.02, 0.15)}),
    'air_cushion_orifice': Form(CUSHION, 'force', 'pad', force.AIR_ORIFICE,
        sized(100.0, 1500.0, 1.0, 2.0, 4.0), 'Wang et al., Pneumatic cushioning, 2000',
        {'length': (0.008, 0.02)}),
    'trapped_air_cushion': Form(CUSHION, 'force', 'pad', force.TRAPPED_AIR, _friction(0.5, 8.0),
        'Beater 2007: adiabatic cushion', {'length': (0.008, 0.02)}),
    'rubber_bumper': Form(CUSHION, 'force', 'pad', force.RUBBER, sized(5e3, 8e4, 1.0, 1.5, 2.0),
        'Hunt and Crossley, J. Appl. Mech. 42, 1975', {'length': (0.006, 0.015),
        'damping': (0.5, 3.0)}),
    'joint_with_play': Form(JOINT, 'force', 'joint', force.BACKLASH, same(5e-5, 4e-4),
        'Nordin and Gutman, Automatica 38, 2002', {'play': (2e-4, 2e-3)}),
    'hardening_joint': Form(JOINT, 'force', 'joint', force.HARDENING, same(1e-4, 8e-4),
        'Duffing 1918; Nayfeh and Mook 1979', {'scale': (5e-4, 3e-3)}),
    'creeping_stop': Form(NONE, 'force', 'stop', force.CREEPING_STOP, same(5e-4, 5e-3),
        'Findley, Creep of Nonlinear Viscoelastic Materials, 1976'),
}  # fmt: skip
SENSOR: dict[str, Form] = {
    'bowed_position': Form(('position_scale',), 'sensor', '', 0, same(2e-4, 4e-3),
        'IEC 61298-2: terminal-based linearity'),
    'drifting_position': Form(NONE, 'sensor', '', 0, same(2e-4, 3e-3), 'IEC 61298-2: drift'),
    'position_play': Form(NONE, 'sensor', '', 0, same(2e-4, 2e-3),
        'IEC 60393: backlash of potentiometers'),
    'two_pole_position_lag': Form(('sensor_delay',), 'sensor', '', 0, same(0.002, 0.015),
        'Doebelin, Measurement Systems'),
    'drifting_pressure_zero': Form(('pressure_offset',), 'sensor', '', 0, same(6e2, 6e3),
        'IEC 61298-2: drift'),
    'warming_pressure_zero': Form(('pressure_offset',), 'sensor', '', 0, same(6e2, 6e3),
        'IEC 61298-3: zero over temperature', {'time': (2.0, 8.0)}),
    'bowed_pressure': Form(('pressure_offset',), 'sensor', '', 0, same(1e3, 1e4),
        'IEC 61298-2: terminal-based linearity'),
    'slow_pressure_sensor': Form(NONE, 'sensor', '', 0, same(0.005, 0.06),
        'Doebelin, Measurement Systems: tubing'),
}  # fmt: skip
FORMS = {**GAS, **FORCE, **SENSOR}
"""Name -> form."""
KNOWN = tuple(name for name, form in FORMS.items() if form.mechanism)
UNKNOWN = tuple(name for name, form in FORMS.items() if not form.mechanism)
NUMBERS = frozenset(
    f'{name}.{number}' for name, form in FORMS.items() for number in ('strength', *form.shape)
)
"""What can be hidden, form.number."""


def is_form(name: str) -> bool:
    """Whether form.number, or a form, is one of these."""
    return name.split('.')[0] in FORMS


def mechanism(name: str) -> tuple[str, ...]:
    """Return the names that are right for what is hidden; an effect's is its own."""
    return FORMS[name].mechanism if name in FORMS else (name,)


def numbers(hidden: Mapping[str, float]) -> np.ndarray:
    """
    Return the flat numbers of the forms in the plant, none where there are none.

    :param hidden: form.number -> value; numbers of other things are not read
    """
    names = {name.split('.')[0] for name in hidden if name in NUMBERS}
    inside = sorted(name for name in names if FORMS[name].slot)
    flat = np.zeros(at.WIDTH * len(at.SLOTS))
    for name in inside:
        form, strength = FORMS[name], hidden.get(f'{name}.strength', 0.0)
        place = at.WIDTH * at.SLOTS.index(form.slot)
        assert not flat[place], f'{name}: two forms in one place'
        shape = [hidden[f'{name}.{number}'] for number in form.shape]
        flat[place : place + 2 + len(shape)] = form.code, strength, *shape
        if form.also:
            place = at.WIDTH * at.SLOTS.index(form.also[0])
            flat[place : place + 2] = form.also[1], strength
    return flat if inside else np.empty(0)
