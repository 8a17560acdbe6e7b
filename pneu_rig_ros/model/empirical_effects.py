"""
The effects that add empirical terms to the plant: one for each balance, made of the table.

They describe what no physical effect explains, and are not causes themselves.
"""

from collections.abc import Callable, Sequence
from types import new_class
from typing import Annotated, Any, NamedTuple

from pneu_rig_ros.arrays import Floats
from pneu_rig_ros.model.compiled import called, compiled, in_turn
from pneu_rig_ros.model.compiled_model import CompiledModel, Motion, Pair, Signals
from pneu_rig_ros.model.effect import Balance, Effect, Regime
from pneu_rig_ros.model.empirical import OUTPUTS, TERMS
from pneu_rig_ros.model.quantity import Quantity
from pneu_rig_ros.model.shape import DRIVERS

Sum = Callable[[Signals, CompiledModel, Any, Floats, Floats], float]
Guard = Callable[[float, float, Signals, CompiledModel], Pair]

SOURCE = 'a fit to data: a description, not a cause'


SIGNALS = {f'signal_{name}': compiled(term.signal) for name, term in TERMS.items()}


def _sum(names: Sequence[str], place: int, slot: int) -> Sum:
    """Return the terms times their coefficients, which begin at a place, as the states do."""
    steps = []
    for index, name in enumerate(names, start=place):
        value = f'signal_{name}(s, model) if c[{index}] != 0.0 else 0.0'
        if TERMS[name].integrated:
            steps += [f'rate[{slot}] = {value}', f'total += c[{index}] * state[{slot}]']
            slot += 1
        else:
            steps.append(f'total += c[{index}] * ({value})')
    return compiled(in_turn('terms', 's, model, c, state, rate', 'total = 0.0', steps, SIGNALS))


@compiled
def _as_they_are(first: float, second: float, s: Signals, model: CompiledModel) -> Pair:
    return first, second


@compiled
def _from_what_is_left(first: float, second: float, s: Signals, model: CompiledModel) -> Pair:
    """Let less flow out of a chamber with little gas left: none out of an empty one."""
    left_1 = min(s.gas.pressure_1 / model.gas.atmospheric_pressure, 1.0)
    left_2 = min(s.gas.pressure_2 / model.gas.atmospheric_pressure, 1.0)
    return max(first, first * left_1), max(second, second * left_2)


@compiled
def _from_what_is_warm(first: float, second: float, s: Signals, model: CompiledModel) -> Pair:
    """Let less heat out of a cold gas: none out of one without any."""
    scale = model.gas.gas_constant * model.gas.supply_temperature
    left_1 = min(s.gas.pressure_1 * s.gas.volume_1 / (s.gas.gas_mass_1 * scale), 1.0)
    left_2 = min(s.gas.pressure_2 * s.gas.volume_2 / (s.gas.gas_mass_2 * scale), 1.0)
    return max(first, first * left_1), max(second, second * left_2)


@compiled
def _static_on_top(first: float, second: float, s: Signals, model: CompiledModel) -> Pair:
    return first, first + second


def _pair(first: Sum, second: Sum, guard: Guard) -> Callable[..., Pair]:
    @called
    def contribution(
        s: Signals, model: CompiledModel, c: Any, state: Floats, rate: Floats
    ) -> Pair:
        a = first(s, model, c, state, rate)
        b = second(s, model, c, state, rate)
        return guard(a, b, s, model)

    return contribution


STEP = 1e-4
"""Of a difference over the position, as a share of the stroke [-]."""


def _rate_of(total: Sum) -> Sum:
    """
    Return how fast a sum changes as the piston moves [1/s].

    By central differences, which are exact up to squares of the position.
    """

    @compiled
    def rate_of(s: Signals, model: CompiledModel, c: Any, state: Floats, rate: Floats) -> float:
        step = STEP * model.cylinder.stroke
        ahead = total(_moved(s, step), model, c, state, rate)
        behind = total(_moved(s, -step), model, c, state, rate)
        return (ahead - behind) / (2.0 * step) * s.motion.velocity

    return rate_of


@compiled
def _moved(signals: Signals, way: float) -> Signals:
    motion = Motion(signals.motion.position + way, signals.motion.velocity)
    return Signals(signals.time, motion, signals.gas, signals.ports, signals.seal)


def _parameters(name: str) -> type[Any]:
    """Return the class of the parameters of an effect, all zero unless they are given."""
    quantities: dict[str, Quantity] = {}
    for output in OUTPUTS.values():
        if output.effect == name:
            quantities |= output.parameters
    body = {
        '__module__': __name__,
        '__doc__': 'Coefficients of the terms.',
        '__annotations__': {key: Annotated[float, one] for key, one in quantities.items()},
        **dict.fromkeys(quantities, 0.0),
    }
    bases: Any = (NamedTuple,)
    return new_class(name, bases, exec_body=lambda space: space.update(body))


def _sums(name: str) -> tuple[list[Sum], tuple[str, ...]]:
    """Return the sum of each output of an effect, and the names of the states."""
    sums: list[Sum] = []
    states: list[str] = []
    place = 0
    for output in (one for one in OUTPUTS.values() if one.effect == name):
        sums.append(_sum(output.terms, place, len(states)))
        states += [output.parameter.format(t) for t in output.terms if TERMS[t].integrated]
        place += len(output.terms)
    return sums, tuple(states)


def _effect(name: str, title: str, balance: Balance, probes: tuple[float, float]) -> Effect:
    """Return the effect of the outputs that name it; every coefficient of a probe is the same."""
    parameters, (sums, states) = _parameters(name), _sums(name)
    if balance is Balance.MOTION_READING:
        sums.append(_rate_of(sums[0]))
    guard = GUARDS.get(balance, _as_they_are)
    return Effect(
        title=title,
        balance=balance,
        regimes=REGIMES.get(balance, tuple(Regime)),
        source=SOURCE,
        null=parameters(),
        contribution=_pair(sums[0], sums[1] if len(sums) > 1 else _sum((), 0, 0), guard),
        probes=tuple([value] * len(parameters._fields) for value in probes),
        stage=3 if balance is Balance.SPOOL else 0,
        states=states,
        describes=True,
        as_array=True,
        drivers=tuple(DRIVERS),
    )


GUARDS: dict[Balance, Guard] = {
    Balance.MASS: _from_what_is_left,
    Balance.HEAT: _from_what_is_warm,
    Balance.LEVEL: _static_on_top,
}
REGIMES = {
    Balance.LEVEL: (Regime.BREAKAWAY, Regime.SLIDING),
    Balance.SPOOL: (Regime.DWELL, Regime.SLIDING, Regime.END_STOP),
}
EFFECTS: dict[str, Effect] = {
    name: _effect(name, f'{what} without a known cause', balance, probes)
    for name, what, balance, probes in (
        ('empirical_flow', 'a flow', Balance.MASS, (1e-6, -1e-6)),
        ('empirical_force', 'a force', Balance.FORCE, (0.5, -0.5)),
        ('empirical_friction', 'a level of friction', Balance.LEVEL, (0.3, -0.1)),
        ('empirical_heat', 'a heat flow', Balance.HEAT, (1.0, -1.0)),
        (
            'empirical_position_reading',
            'an error of the position sensor',
            Balance.MOTION_READING,
            (1e-3, -1e-3),
        ),
        (
            'empirical_pressure_reading',
            'an error of the pressure sensors',
            Balance.PRESSURE_READING,
            (1e3, -1e3),
        ),
        ('empirical_voltage', 'an error of the valve spools', Balance.SPOOL, (0.02, -0.02)),
    )
}
# where pickle finds the classes
globals().update({name: effect.parameters for name, effect in EFFECTS.items()})
