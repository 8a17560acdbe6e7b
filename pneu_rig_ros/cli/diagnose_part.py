"""`pneu-rig diagnose` for a part of a rig alone: chambers, friction or valves."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pneu_rig_ros.cli import output

if TYPE_CHECKING:
    from pneu_rig_ros.gap.parts.diagnosis import PartDiagnosis


def is_part(model: str, kind: str | None) -> bool:
    """Return whether a part is to be diagnosed: so the option, or the model's file, says."""
    if kind is not None:
        return True
    from pneu_rig_ros.gap.parts.part import describes_part

    return describes_part(model)


def diagnose_part(
    bags: Sequence[Path], verify: Sequence[Path], mapping: Path | None, out: Path,
    settings: dict[str, Any], quiet: bool,
) -> dict[str, Any]:  # fmt: skip
    """Diagnose a part behind a progress bar and write the files; return diagnosis.json."""
    from pneu_rig_ros.gap.parts import diagnosis as parts

    with output.stage_bar(quiet=quiet) as tell:
        found = parts.diagnose_part(
            bags, settings['model'], mapping, verify, settings['part'], settings['without'],
            settings['executor'], tell,
        )  # fmt: skip
        data = parts.answer(found)
        _write(out, found, data)
    return data


def _write(out: Path, found: PartDiagnosis, data: dict[str, Any]) -> None:
    from pneu_rig_ros.report.part_page import write_part_page
    from pneu_rig_ros.report.writing import write_whole

    write_whole(out / 'diagnosis.json', json.dumps(data, indent=2, allow_nan=False) + '\n')
    write_part_page(out / 'report.html', found, data)
    write_whole(out / 'improved.yaml', found.improved.to_yaml())
