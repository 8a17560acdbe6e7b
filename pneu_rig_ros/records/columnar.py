"""Reads the cells of a large text table with pyarrow, column by column and on all processors."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Union

import numpy as np

from pneu_rig_ros.records.recording import Floats

if TYPE_CHECKING:
    from pyarrow import ChunkedArray

Column = Union[Sequence[str], 'ChunkedArray']
"""The texts of a column."""


def read_texts(data: bytes, start: int, separator: str, width: int) -> list[Column] | None:
    """
    Return the columns of a table, None if it is not regular or pyarrow is not installed.

    :param data: UTF-8
    :param start: of the first row of data [byte]
    :param width: cells of a row
    """
    try:
        import pyarrow
        from pyarrow import csv
    except ImportError:
        return None
    names = [str(index) for index in range(width)]
    kinds = dict.fromkeys(names, pyarrow.string())
    try:
        table = csv.read_csv(
            pyarrow.BufferReader(pyarrow.py_buffer(data)[start:]),
            csv.ReadOptions(column_names=names),
            csv.ParseOptions(delimiter=separator),
            csv.ConvertOptions(column_types=kinds, strings_can_be_null=False),
        )
    except pyarrow.ArrowInvalid:
        return None
    return list(table.columns)


def as_numbers(column: ChunkedArray, decimal: str) -> Floats | None:
    """Return the numbers of a column, shape (n,); None if a cell is not a plain number."""
    import pyarrow
    from pyarrow import compute

    texts = compute.utf8_trim_whitespace(column)
    if decimal == ',':
        texts = compute.replace_substring(texts, '.', '#')
        texts = compute.replace_substring(texts, ',', '.')
    try:
        return np.asarray(compute.cast(texts, pyarrow.float64()), dtype=np.float64)
    except pyarrow.ArrowInvalid:
        return None


def release_memory() -> None:
    """Return the memory of tables that are gone to the system; pyarrow would keep it."""
    if pyarrow := sys.modules.get('pyarrow'):
        pyarrow.default_memory_pool().release_unused()
