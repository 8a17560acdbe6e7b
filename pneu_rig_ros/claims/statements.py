"""
The paper's statements, each measured on simulated strokes.

A statement holds if all its findings hold. Where the text gives words ("nearly unchanged",
"extremely small"), the finding states the number that stands for them. Where a finding compares
dwells or slips of strokes, these are the medians of each. A dwell is a rest of
``analysis.motion``: slower than 1 mm/s for at least 60 ms.
"""

from pneu_rig_ros.claims import captions, trends
from pneu_rig_ros.claims.dwell_law import dwell_law
from pneu_rig_ros.claims.estimation import estimated_friction
from pneu_rig_ros.claims.experiments import Laboratory
from pneu_rig_ros.claims.findings import Row, Statement

_MEASURES = {
    'cylinder 1 rests for seconds and slips; dwells and peaks decrease': captions.cylinder_1,
    'cylinder 2 has shorter dwells and smaller slips': captions.cylinder_2,
    'cylinder 3 has many more, very short, very small cycles': captions.cylinder_3,
    'more airflow: fewer events, shorter stroke': trends.airflow,
    'more supply pressure: shorter stroke and dwells, larger steps': trends.supply,
    'more load: as many cycles, larger slips, slightly shorter stroke': trends.load,
    'further start: longer first dwell, later dwells and slips unchanged': trends.initial_position,
    'RLG misses the cycles; Eq. 16 persists and attenuates': captions.constant_static_friction,
    'static friction grows with dwell time along Eq. 16': dwell_law,
    'Eq. 2 gives back the friction of the model': estimated_friction,
    'some sticking phases of cylinder 2 creep, in general none': captions.creep,
    'intermediate airflow: shorter dwells, larger slips': trends.intermediate_airflow,
    'pronounced steps at 3 and 4 bar': trends.low_supply,
    'RLG gets the first cycle, not the later ones': captions.first_cycles,
    'dwells, pressure and friction peaks vary gradually, unlike with RLG': captions.evolution,
    'no valve passes more than 720 L/min': trends.valve_flow,
    'the guide has 10-15 % of the friction at any speed': trends.guide_friction,
}
STATEMENTS = tuple(
    Statement(number, text, measure)
    for number, (text, measure) in enumerate(_MEASURES.items(), start=1)
)
"""All statements: 1-10 the main ones, 11-17 details."""


def measure(laboratory: Laboratory, statement: Statement) -> Row:
    """Measure one statement."""
    return Row(statement, tuple(statement.measure(laboratory)))
