"""The statements as a short table in Markdown."""

from collections.abc import Mapping, Sequence

from pneu_rig_ros.claims.findings import Row


def markdown(rows: Sequence[Row], shares: Mapping[int, float] | None = None) -> str:
    """
    Return a line for each statement: verdict, and the finding with the least margin.

    :param rows: statements, measured
    :param shares: number of a statement -> share of the neighbours under which it holds [-]
    """
    titles = ['', 'the paper says', 'holds', 'tightest finding: measured']
    if shares:
        titles.insert(3, 'neighbours')
    lines = [f'| {" | ".join(titles)} |'.replace('|  |', '| |'), '| --- ' * len(titles) + '|']
    for row in rows:
        number = row.statement.number
        tightest = row.tightest
        cells = [
            str(number), row.statement.text, 'yes' if row.holds else 'no',
            f'{tightest.says}: {tightest.measured}'.replace('cylinder_', 'cylinder '),
        ]  # fmt: skip
        if shares:
            cells.insert(3, f'{shares[number]:.0%}')
        lines.append(f'| {" | ".join(cells)} |')
    return '\n'.join(lines)
