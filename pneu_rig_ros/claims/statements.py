"""
The paper's statements, each measured on simulated strokes.

A statement holds when each of its findings does. What the text gives in words ("nearly
unchanged", "extremely small") is put into a number in the finding itself, so that it can be read.
Where a finding compares dwells or slips of strokes, these are the medians of each. A dwell is a
rest of ``analysis.motion``: slower than 1 mm/s for at least 60 ms.
"""

from pneu_rig_ros.claims import captions, trends
from pneu_rig_ros.claims.dwell_law import dwell_law
from pneu_rig_ros.claims.estimation import estimated_friction
from pneu_rig_ros.claims.experiments import Laboratory
from pneu_rig_ros.claims.findings import Row, Statement

STATEMENTS = (
    Statement(
        1, 'cylinder 1 rests for seconds and slips; dwells and peaks decrease',
        captions.cylinder_1,
    ),
    Statement(2, 'cylinder 2 has shorter dwells and smaller slips', captions.cylinder_2),
    Statement(3, 'cylinder 3 has many more, very short, very small cycles', captions.cylinder_3),
    Statement(4, 'more airflow: fewer events, shorter stroke', trends.airflow),
    Statement(5, 'more supply pressure: shorter stroke and dwells, larger steps', trends.supply),
    Statement(6, 'more load: as many cycles, larger slips, slightly shorter stroke', trends.load),
    Statement(
        7, 'further start: longer first dwell, later dwells and slips unchanged',
        trends.initial_position,
    ),
    Statement(
        8, 'RLG misses the cycles; Eq. 16 persists and attenuates',
        captions.constant_static_friction,
    ),
    Statement(9, 'static friction grows with dwell time along Eq. 16', dwell_law),
    Statement(10, 'Eq. 2 gives back the friction of the model', estimated_friction),
    Statement(11, 'some sticking phases of cylinder 2 creep, in general none', captions.creep),
    Statement(
        12, 'intermediate airflow: shorter dwells, larger slips', trends.intermediate_airflow
    ),
    Statement(13, 'pronounced steps at 3 and 4 bar', trends.low_supply),
    Statement(14, 'RLG gets the first cycle, not the later ones', captions.first_cycles),
    Statement(
        15, 'dwells, pressure and friction peaks vary gradually, unlike with RLG',
        captions.evolution,
    ),
    Statement(16, 'no valve passes more than 720 L/min', trends.valve_flow),
    Statement(17, 'the guide has 10-15 % of the friction at any speed', trends.guide_friction),
)  # fmt: skip
"""All statements; 1-10 as numbered in the project's notes, then the smaller ones."""


def measure(laboratory: Laboratory, statement: Statement) -> Row:
    """Measure one statement."""
    return Row(statement, tuple(statement.measure(laboratory)))
