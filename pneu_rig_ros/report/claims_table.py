"""The statements as a short table in Markdown."""

from collections.abc import Sequence

from pneu_rig_ros.claims.findings import Row


def markdown(rows: Sequence[Row]) -> str:
    """Return a line for each statement: verdict, and the finding with the least margin."""
    lines = ['| | the paper says | holds | tightest finding: measured |', '| --- ' * 4 + '|']
    for row in rows:
        worst = min(row.findings, key=lambda finding: finding.clipped_margin)
        says = worst.says.replace('cylinder_', 'cylinder ')
        verdict = 'yes' if row.holds else 'no'
        statement = row.statement
        lines.append(
            f'| {statement.number} | {statement.text} | {verdict} | {says}: {worst.measured} |'
        )
    return '\n'.join(lines)
