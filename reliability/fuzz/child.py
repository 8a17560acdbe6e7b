"""
One reader tried in a process of its own, whose memory and time are bounded.

``python -m reliability.fuzz.child METHOD READER SECONDS SEED`` tries for so long, once all is
loaded, and prints the tally as JSON. Methods:
``random`` (hypothesis), ``guided`` (atheris: by the coverage of the code), ``damage`` (bags).
"""

from __future__ import annotations

import dataclasses
import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from reliability.fuzz.attempt import Tally

PACKAGES = ('pneu_rig_ros.records', 'pneu_rig_ros.rig', 'pneu_rig_ros.control', 'yaml', 'rosbags',
            'pneu_rig_ros.diagnosis.system', 'pneu_rig_ros.claims.readings')  # fmt: skip
"""What atheris watches."""
TELL_EVERY = 0.25
"""Time between two tallies of a guided run, which ends without a word [s]."""
FAILURES = Path('build/fuzz')


def main() -> None:
    """Run what the command line says."""
    method, name, seconds, seed = sys.argv[1], sys.argv[2], float(sys.argv[3]), int(sys.argv[4])
    scratch = '/dev/shm' if Path('/dev/shm').is_dir() else None
    with tempfile.TemporaryDirectory(dir=scratch, prefix='pneu_rig_fuzz_') as folder:
        if method == 'guided':
            _guided(name, seconds, seed, Path(folder))
        else:
            run = _random if method == 'random' else _damage
            run(name, seconds, seed, Path(folder))


def _tell(tally: Tally) -> None:
    from reliability.fuzz.attempt import peak_memory

    print(json.dumps(dataclasses.asdict(tally) | {'memory': peak_memory()}), flush=True)


def _random(name: str, seconds: float, seed: int, folder: Path) -> None:
    import hypothesis

    from reliability.fuzz.attempt import Tally, attempt, limit_memory
    from reliability.fuzz.inputs import edited
    from reliability.fuzz.readers import READERS

    reader, tally = READERS[name], Tally()
    given = edited(reader.seeds(), reader.tokens)
    settings = hypothesis.settings(
        max_examples=200, deadline=None, database=None, phases=[hypothesis.Phase.generate],
        suppress_health_check=list(hypothesis.HealthCheck),
    )  # fmt: skip

    @settings
    @hypothesis.given(given)
    def try_it(data: bytes) -> None:
        if time.monotonic() < end:
            attempt(name, data, folder, tally, FAILURES)

    for data in reader.seeds():
        attempt(name, data, folder, tally, FAILURES)
    limit_memory()
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        seed += 1
        hypothesis.seed(seed)(try_it)()
    _tell(tally)


def _damage(name: str, seconds: float, seed: int, folder: Path) -> None:
    from reliability.fuzz import damage
    from reliability.fuzz.attempt import Tally, attempt, limit_memory
    from reliability.fuzz.readers import READERS

    tally = Tally()
    attempt(name, READERS[name].seeds()[0], folder, tally, FAILURES)
    limit_memory()
    end = time.monotonic() + seconds
    for data in damage.all_of(name, max(seed, 1)):
        attempt(name, data, folder, tally, FAILURES)
        if time.monotonic() > end:
            break
    _tell(tally)


def _guided(name: str, seconds: float, seed: int, folder: Path) -> None:
    import atheris

    with atheris.instrument_imports(include=list(PACKAGES), enable_loader_override=False):
        from reliability.fuzz.readers import READERS
    from reliability.fuzz.attempt import Tally, attempt, limit_memory

    corpus, scratch = folder / 'corpus', folder / 'scratch'
    corpus.mkdir()
    scratch.mkdir()
    for number, data in enumerate(READERS[name].seeds()):
        (corpus / str(number)).write_bytes(data)
    tokens = folder / 'tokens'
    tokens.write_text(''.join(f'"{_escaped(token)}"\n' for token in READERS[name].tokens))
    tally = Tally()
    limit_memory()
    try_it = _told(lambda data: attempt(name, data, scratch, tally, FAILURES), tally)
    options = (
        f'-max_total_time={max(round(seconds), 1)}',
        f'-seed={seed + 1}',
        f'-dict={tokens}',
        '-timeout=20',
        '-rss_limit_mb=4000',
        '-max_len=60000',
    )
    atheris.Setup([sys.argv[0], *options, str(corpus)], try_it)
    atheris.Fuzz()


def _told(run: Callable[[bytes], None], tally: Tally) -> Callable[[bytes], None]:
    """Return what also prints the tally now and then, as libFuzzer ends the process itself."""
    due = 0.0

    def try_it(data: bytes) -> None:
        nonlocal due
        run(data)
        if time.monotonic() > due:
            _tell(tally)
            due = time.monotonic() + TELL_EVERY

    return try_it


def _escaped(token: bytes) -> str:
    return ''.join(f'\\x{byte:02x}' for byte in token[:60])


if __name__ == '__main__':
    main()
