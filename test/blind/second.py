"""
The second list of forms: the laws of ``second_gas``, ``_force`` and ``_sensors``.

As those of ``foreign``, of which no formula is repeated; their strengths are in
``second_strengths``.
"""

from . import second_force as force
from . import second_gas as gas
from .foreign import (
    BRISTLES,
    CROSS,
    CURVE,
    CUSHION,
    DROOP,
    DWELL,
    FILM,
    HEAT,
    JOINT,
    LAG,
    LEAK,
    LINE,
    NONE,
    NULL,
    PART,
    PLACE,
    PLAY,
    PRESSURE,
    SIDE,
    SPRING,
    STRIBECK,
    WARM,
    Form,
    balanced,
)

GAS = {
    'inflow_heat': Form(HEAT, 'heat', gas.BY_INFLOW,
        'Woodfield, Monde and Mitsutake, J. Thermal Sci. Tech. 2, 2007', {'time': (0.1, 1.0)}),
    'cracking_regulator': Form(DROOP, 'supply', gas.CRACKING_DROOP,
        'ISO 6953: characteristic of a regulator', {'flow': (1e-5, 6e-5)}),
    'round_ports': Form(CURVE, 'curve', gas.ROUND_PORT,
        'Merritt, Hydraulic Control Systems, 1967: round ports'),
    'pressed_slit_leak': Form(LEAK, 'leak', gas.PRESSED_SLIT,
        'Mueller and Nau, Fluid Sealing Technology, 1998',
        {'pressure': (2e5, 8e5), 'first': PART}),
    'one_way_lip_leak': Form(CROSS, 'cross_leak', gas.ONE_WAY_LIP,
        'Mueller and Nau 1998: a lip seals against one side'),
    'notched_land_leak': Form(NULL, 'null_leak', gas.NOTCHED_LAND,
        'Borghi, Milani and Paoluzzi, Int. J. Fluid Power 6, 2005',
        {'reach': (1.3, 3.0), 'exhaust': (1.0, 3.0)}),
    'eddy_current_spool': Form(LAG, 'spool', gas.EDDY_CURRENT,
        'Roters, Electromagnetic Devices, 1941', {'time': (0.05, 0.3)}),
    'bouc_wen_spool': Form(PLAY, 'play', gas.BOUC_WEN,
        'Wen, J. Eng. Mech. 102, 1976', {'travel': (0.1, 0.6)}),
    'darcy_line': Form(LINE, 'line', gas.DARCY_LINE,
        'Blasius, VDI Forschungsarbeiten 131, 1913; strength is the length',
        {'bore': (2e-3, 4e-3)}),
    'hunting_spool': Form(NONE, 'spool', gas.HUNTING,
        'Gelb and Vander Velde, Multiple-Input Describing Functions, 1968: limit cycles',
        {'frequency': (1.0, 4.0)}),
    'warming_coil': Form(NONE, 'spool', gas.WARM_COIL,
        'IEC 60028: copper over temperature', {'time': (1.0, 6.0)}),
    'side_volume': Form(NONE, 'gas_law', gas.SIDE_VOLUME,
        'Andersen, Pneumatic Systems, 1967: capacity behind a resistance', {'time': (0.1, 1.0)}),
}  # fmt: skip
FORCE = {
    'thirion_seal': Form(PRESSURE, 'pressure', force.THIRION,
        'Thirion, Rev. Gen. Caoutchouc 23, 1946', {'bars': (1.0, 4.0)}),
    'side_loaded_rod': Form(PLACE, 'position', force.SIDE_LOAD,
        'Timoshenko, Strength of Materials: reactions of an overhanging beam',
        {'bearing': (0.2, 0.8)}),
    'warming_and_cooling': Form(WARM, 'warming', force.HEAT_BALANCE,
        'Reynolds, Phil. Trans. 177, 1886: viscosity; Newton: cooling',
        {'work': (0.5, 2.0), 'time': (1.0, 6.0)}),
    'root_of_speed_outward': Form(SIDE, 'side', force.ROOT_OUTWARD,
        'Blok, Inverse problems in hydrodynamic lubrication, 1963'),
    'relaxing_lip': Form(BRISTLES, 'bristle', force.RELAXING,
        'Ferry, Viscoelastic Properties of Polymers, 1980',
        {'bend': (2e-4, 1e-3), 'time': (0.1, 2.0)}),
    'tanh_curve': Form(STRIBECK, 'shape', force.TANH_CURVE,
        'Makkar et al., IEEE/ASME AIM, 2005', {'speed': (0.7, 2.0)}, base='coulomb_viscous'),
    'squeezed_out_dwell': Form(DWELL, 'dwell', force.SQUEEZED_OUT,
        'Moore, The Friction and Lubrication of Elastomers, 1972', {'time': (0.1, 5.0)},
        base='revised_lugre'),
    'entrained_film': Form(FILM, 'film', force.ENTRAINED,
        'Hamrock, Fundamentals of Fluid Film Lubrication: entraining and squeeze',
        {'distance': (0.002, 0.02), 'time': (0.05, 1.0)}, base='lugre'),
    'rubber_cord': Form(SPRING, 'load', force.RUBBER_CORD,
        'Treloar, The Physics of Rubber Elasticity, 1975', {'stretch': (0.5, 2.0)}),
    'needle_cushion': Form(CUSHION, 'pad', force.NEEDLE_VALVE,
        'Beater, Pneumatic Drives, 2007: cushion with a throttle',
        {'length': (0.008, 0.02), 'time': (0.02, 0.2)}),
    'dry_joint': Form(JOINT, 'joint', force.DRY_JOINT,
        'Den Hartog, Trans. ASME 53, 1931', {'friction': (0.3, 2.0)}),
    'holding_magnet': Form(NONE, 'load', force.HOLDING_MAGNET,
        'Furlani, Permanent Magnet and Electromechanical Devices, 2001', {'gap': (0.002, 0.008)}),
    'eddy_current_brake': Form(NONE, 'viscous', force.EDDY_BRAKE,
        'Smythe, Trans. AIEE 61, 1942', {'speed': (0.03, 0.12)}),
}  # fmt: skip
SENSOR = {
    'loaded_potentiometer': Form(('position_scale',), '', 0,
        'Doebelin, Measurement Systems: loading of potentiometers'),
    'averaged_position': Form(('sensor_delay',), '', 0,
        'Oppenheim and Schafer, Discrete-Time Signal Processing: moving average'),
    'interpolated_position': Form(NONE, '', 0,
        'Heydemann, Applied Optics 20, 1981: interpolation within a period',
        {'period': (0.012, 0.03)}),
}  # fmt: skip
SECOND = balanced(GAS, FORCE, SENSOR)
"""Name -> form."""
SECOND_KNOWN = tuple(name for name, form in SECOND.items() if form.mechanism)
SECOND_UNKNOWN = tuple(name for name, form in SECOND.items() if not form.mechanism)
