"""
The parameters of the model, section by section: symbol, unit, allowed range.

Each section is a ``NamedTuple`` so that the compiled plant reads it by name. Tables 1 and 2 of
the paper are in ``config/cylinder_*.yaml`` (cylinder, friction) and ``config/rig.yaml`` (valve,
gas).
"""

from typing import Annotated, NamedTuple

from pneu_rig_ros.model.quantity import Choice, Quantity, QuantityList

COULOMB_VISCOUS, LUGRE, REVISED_LUGRE, REVISED_LUGRE_DWELL = range(4)
FRICTION_MODELS = ('coulomb_viscous', 'lugre', 'revised_lugre', 'revised_lugre_dwell')

FOLLOWS_CLOCK, LATCHED_AT_BREAKAWAY, HELD_TO_NEXT_BREAKAWAY, FADES_WHILE_SLIDING = range(4)
STATIC_FRICTION_READINGS = (
    'follows_clock',
    'latched_at_breakaway',
    'held_to_next_breakaway',
    'fades_while_sliding',
)

FILM_PRINTED, FILM_NORMALISED = range(2)
FILM_READINGS = ('printed', 'normalised')

FILM_RESTS_WITH_CLOCK, FILM_RESTS_BY_SPEED = range(2)
FILM_REST_READINGS = ('with_dwell_clock', 'by_speed')


class Cylinder(NamedTuple):
    """Double-acting cylinder: Table 1 (documentation) and Table 2 (used)."""

    cap_area: Annotated[float, Quantity('m^2', 1e-6, 1e-1, 'piston area of chamber 1, A1')]
    rod_area: Annotated[float, Quantity('m^2', 1e-6, 1e-1, 'piston area of chamber 2, A2')]
    cap_dead_volume: Annotated[float, Quantity('m^3', 1e-7, 1e-1, 'dead volume, V10')]
    rod_dead_volume: Annotated[float, Quantity('m^3', 1e-7, 1e-1, 'dead volume, V20')]
    stroke: Annotated[float, Quantity('m', 1e-3, 10.0, 'stroke, L')]
    moving_mass: Annotated[float, Quantity('kg', 1e-3, 1e3, 'piston and rod, without load')]
    bore: Annotated[float, Quantity('m', 1e-3, 0.5, 'bore diameter (Table 1)')]
    rod_diameter: Annotated[float, Quantity('m', 1e-3, 0.5, 'rod diameter (Table 1)')]


class Friction(NamedTuple):
    """Seal and guide friction, Eq. 9-16."""

    model: Annotated[int, Choice(FRICTION_MODELS, 'friction law')]
    breakaway_force: Annotated[float, Quantity('N', 0.0, 1e5, 'static friction, F_s and F_smax')]
    coulomb_force: Annotated[float, Quantity('N', 1e-6, 1e5, 'Coulomb friction, F_c')]
    stribeck_velocity: Annotated[float, Quantity('m/s', 1e-6, 10.0, 'Stribeck velocity, v_s')]
    stribeck_exponent: Annotated[float, Quantity('-', 0.1, 10.0, 'Stribeck exponent, n')]
    viscous_coefficient: Annotated[float, Quantity('N*s/m', 0.0, 1e5, 'viscous friction, sigma_2')]
    micro_viscous_coefficient: Annotated[
        float, Quantity('N*s/m', 0.0, 1e4, 'micro-viscous friction, sigma_1')
    ]
    element_stiffness: Annotated[
        tuple[float, ...],
        QuantityList(Quantity('N/m', 1e2, 1e8, 'stiffness of each element of F(z)'), 10),
    ]
    element_limit: Annotated[
        tuple[float, ...],
        QuantityList(
            Quantity('N', 1e-6, 1e5, 'slip limit of each element but the last, which holds'), 9
        ),
    ]
    film_velocity: Annotated[
        float, Quantity('m/s', 1e-6, 10.0, 'velocity up to which the film grows, v_b')
    ]
    film_time_acceleration: Annotated[float, Quantity('s', 1e-4, 1e4, 'tau_hp')]
    film_time_deceleration: Annotated[float, Quantity('s', 1e-4, 1e4, 'tau_hm, also tau_hn')]
    film_time_dwell: Annotated[float, Quantity('s', 1e-4, 1e6, 'tau_h0')]
    fluid_time_constant: Annotated[float, Quantity('s', 0.0, 10.0, 'T of Eq. 9')]
    dwell_exponent: Annotated[float, Quantity('-', 0.01, 2.0, 'alpha of Eq. 16')]
    dwell_coefficient: Annotated[float, Quantity('s^-alpha', 0.0, 1e3, 'gamma of Eq. 16')]
    stop_velocity: Annotated[
        float, Quantity('m/s', 1e-7, 1.0, 'speed below which the piston counts as at rest')
    ]
    start_velocity: Annotated[
        float, Quantity('m/s', 1e-7, 1.0, 'speed above which the piston counts as sliding')
    ]
    static_friction_reading: Annotated[
        int, Choice(STATIC_FRICTION_READINGS, 'what F_s of Eq. 16 does during the slip')
    ]
    memory_time: Annotated[
        float, Quantity('s', 1e-3, 1e6, 'sliding fades F_s - F_c so fast, if fades_while_sliding')
    ]
    film_reading: Annotated[int, Choice(FILM_READINGS, 'h of Eq. 12-15 with a varying F_s')]
    film_rest_velocity: Annotated[
        float, Quantity('m/s', 0.0, 1.0, 'speed below which v = 0 in Eq. 13, when by speed')
    ]
    film_rest_reading: Annotated[int, Choice(FILM_REST_READINGS, 'when v = 0 in Eq. 13')]


class Valve(NamedTuple):
    """Proportional flow valves, Eq. 1 and 3-5."""

    intake_coefficient: Annotated[float, Quantity('m^2/V', 1e-12, 1e-4, 'K_V1')]
    exhaust_coefficient: Annotated[float, Quantity('m^2/V', 1e-12, 1e-4, 'K_V2')]
    intake_voltage: Annotated[float, Quantity('V', 0.0, 5.0, 'intake opens above it, u_m')]
    exhaust_voltage: Annotated[float, Quantity('V', 0.0, 5.0, 'exhaust opens below it, u_n')]
    exhaust_zero_voltage: Annotated[
        float, Quantity('V', 0.0, 5.0, 'exhaust opening counts from it: u_m as printed, or u_n')
    ]
    laminar_pressure_ratio: Annotated[
        float, Quantity('-', 0.9, 1.0 - 1e-9, 'flow is linear in the difference above this ratio')
    ]


class Gas(NamedTuple):
    """Air and surroundings."""

    atmospheric_pressure: Annotated[float, Quantity('Pa', 5e4, 1.2e5, 'p_atm')]
    supply_temperature: Annotated[float, Quantity('K', 200.0, 500.0, 'T_s (T in Table 2)')]
    heat_capacity_ratio: Annotated[float, Quantity('-', 1.0001, 1.7, 'k')]
    gas_constant: Annotated[float, Quantity('J/(kg*K)', 50.0, 5e3, 'R')]


class Operation(NamedTuple):
    """How the rig is set up for a run."""

    supply_pressure: Annotated[float, Quantity('Pa', 1e5, 1.1e6, 'supply pressure, absolute')]
    load_mass: Annotated[float, Quantity('kg', 0.0, 100.0, 'external load')]
    initial_position: Annotated[float, Quantity('m', 0.0, 10.0, 'piston position at the start')]
    initial_pressure_1: Annotated[float, Quantity('Pa', 5e4, 1.1e6, 'p1 at the start, absolute')]
    initial_pressure_2: Annotated[float, Quantity('Pa', 5e4, 1.1e6, 'p2 at the start, absolute')]
    rest_time: Annotated[float, Quantity('s', 0.0, 1e7, 'rest before the start')]


class Model(NamedTuple):
    """All sections together, as the compiled plant takes them."""

    cylinder: Cylinder
    friction: Friction
    valve: Valve
    gas: Gas
    operation: Operation

    @property
    def total_mass(self) -> float:
        """Moving mass M of Eq. 2 and 8 [kg]: piston, rod and external load."""
        return self.cylinder.moving_mass + self.operation.load_mass


SECTIONS: dict[str, type] = dict(Model.__annotations__)
"""Name -> class of each section."""
