"""Columns of numbers in CSV and Parquet files (extra `logs`), in and out.

NumPy reads a million CSV rows of 22 columns in 4 s and 0.2 GB; pyarrow's CSV reader took half the time and two to five
times the memory, so CSV needs no extra package. A Parquet column of lists of numbers (LeRobot's `observation.state`)
counts as a column an entry: `observation.state.0`, `observation.state.1`, ...
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from lwr_dyn.foundation.arrays import Array
from lwr_dyn.foundation.errors import FileAccessError, LogError, MissingPackageError
from lwr_dyn.foundation.files import check_readable, reason_of

SUFFIXES = (".csv", ".parquet")
LARGEST = 2_000_000_000
"""[bytes] The longest CSV file, and the largest table of numbers that is taken from a Parquet file."""
LONGEST_HEAD = 1_000_000
"""Characters of the line of column names."""
LONGEST_LIST = 1000
"""Entries of a list in a cell; a column of longer ones (a picture) stays one column, which is no number."""
_AT = re.compile(r"at row (\d+)")
_BAD_TEXT = re.compile(r"convert string '([^']*)'.* at row (\d+), column (\d+)")


@dataclass(frozen=True, slots=True)
class FileHeader:
    """The column names of a file, and how many lines stand before its first row (0 for Parquet)."""

    names: tuple[str, ...]
    lines: int


def read_head(path: Path) -> FileHeader:
    """The names of the columns; raises `FileAccessError`, `LogError`, `MissingPackageError` (pyarrow for Parquet)."""
    if path.suffix not in SUFFIXES:
        raise FileAccessError(str(path), f"ends in {path.suffix or 'nothing'!r}", "a log that ends in .csv or .parquet")
    check_readable(path, "a log (.csv or .parquet)", LARGEST)
    try:
        if path.suffix == ".parquet":
            return FileHeader(tuple(column.shown for column in _parquet_columns(path, _parquet_file(path))), 0)
        with open(path, encoding="utf-8-sig") as stream:
            for count, line in enumerate(iter(lambda: stream.readline(LONGEST_HEAD), ""), 1):
                if line.strip() and not line.startswith("#"):
                    return FileHeader(tuple(name.strip().strip('"') for name in line.split(",")), count)
    except FileAccessError:
        raise
    except UnicodeDecodeError:
        raise LogError(str(path), "head", "not text", "a CSV file in UTF-8") from None
    except OSError as fault:
        raise FileAccessError(str(path), reason_of(fault), "a log (.csv or .parquet)") from None
    raise LogError(str(path), "head", "the file is empty", "a line of column names, then rows")


def read_columns(path: Path, head: FileHeader, wanted: Sequence[int]) -> Array:
    """The wanted columns (k, len(wanted)) as float64, empty cells and nulls as NaN; raises as `read_head`."""
    if path.suffix == ".parquet":
        return _read_parquet(path, wanted)
    try:
        with open(path, encoding="utf-8-sig") as stream:
            for _ in range(head.lines):
                stream.readline()
            begin = stream.tell()
            if not stream.readline().strip():
                raise LogError(str(path), "rows", "none below the column names", "rows of numbers")
            stream.seek(begin)
            rows = _whole_rows(path, head, stream)
            return np.loadtxt(rows, delimiter=",", usecols=tuple(wanted), ndmin=2, comments=None)
    except LogError:
        raise
    except (ValueError, IndexError) as fault:
        raise _bad_row(path, head, str(fault)) from None
    except OSError as fault:
        raise FileAccessError(str(path), reason_of(fault), "a log (.csv or .parquet)") from None


def _whole_rows(path: Path, head: FileHeader, stream: TextIO) -> Iterator[str]:
    """The lines of the rows. NumPy refuses a row that is too short for the wanted columns, and takes a longer one."""
    commas = len(head.names) - 1
    for row, line in enumerate(stream, 1):
        if line.count(",") > commas:
            where, found = f"row {row} (line {row + head.lines})", f"{line.count(',') + 1} cells"
            needed = f"{len(head.names)} cells in every row, as many as column names"
            raise LogError(str(path), where, found, needed)
        yield line


def _bad_row(path: Path, head: FileHeader, message: str) -> LogError:
    text = _BAD_TEXT.search(message)
    if text is not None:
        row, name = int(text[2]) + 1, head.names[int(text[3]) - 1]
        cell = repr(text[1]) if text[1].strip() else "empty"
        return LogError(str(path), f"row {row} (line {row + head.lines}), column {name}", cell, "a number")
    place = _AT.search(message)
    row = int(place[1]) if place is not None else 1
    where = f"row {row} (line {row + head.lines})"
    return LogError(str(path), where, "not as many cells as columns", f"{len(head.names)} cells in every row")


def _read_parquet(path: Path, wanted: Sequence[int]) -> Array:
    file = _parquet_file(path)
    every, rows = _parquet_columns(path, file), file.metadata.num_rows
    columns = [every[i] for i in wanted]
    if not 0 <= rows * len(wanted) * 8 <= LARGEST:
        raise LogError(str(path), "rows", f"{rows}", f"at most {LARGEST} bytes of numbers")
    out = np.empty((rows, len(wanted)))
    row = 0
    try:
        for batch in file.iter_batches(columns=[*dict.fromkeys(column.name for column in columns)]):
            if row + batch.num_rows > rows:
                raise _not_whole(path)
            for j, column in enumerate(columns):
                cells = batch.column(batch.schema.get_field_index(column.name))
                out[row : row + len(cells), j] = _numbers(path, column.shown, _entries(path, row, column, cells))
            row += batch.num_rows
    except (LogError, FileAccessError):
        raise
    except Exception:  # the decoder meets damaged bytes: its exceptions are of many kinds
        raise _not_whole(path) from None
    if not row:
        raise LogError(str(path), "rows", "none", "rows of numbers")
    return out[:row]


@dataclass(frozen=True, slots=True)
class _ParquetColumn:
    """A column of numbers: one of the file, or the entry `place` of one whose cells are lists of `width` numbers."""

    name: str
    place: int = 0
    width: int | None = None

    @property
    def shown(self) -> str:
        return self.name if self.width is None else f"{self.name}.{self.place}"


def _parquet_columns(path: Path, file: Any) -> list[_ParquetColumn]:
    try:
        return [
            _ParquetColumn(field.name, place, width)
            for field in file.schema_arrow
            for width in (_width(file, field),)
            for place in range(width or 1)
        ]
    except Exception:  # as in `_read_parquet`
        raise _not_whole(path) from None


def _width(file: Any, field: Any) -> int | None:
    """The number of entries in the cells of a column of lists, as its type or its first row has it; None for others."""
    types = _pyarrow()[0].types
    fixed = types.is_fixed_size_list(field.type)
    if not (fixed or types.is_list(field.type) or types.is_large_list(field.type)):
        return None
    number = field.type.value_type
    if not (types.is_floating(number) or types.is_integer(number)):
        return None
    if fixed:
        width = field.type.list_size
    else:
        first = next(file.iter_batches(batch_size=1, columns=[field.name]), None)
        width = len(first.column(0)[0]) if first is not None and first.column(0)[0].is_valid else 0
    return width if 0 < width <= LONGEST_LIST else None


def _entries(path: Path, row: int, column: _ParquetColumn, cells: Any) -> Any:
    """The cells, or one entry of every list; `row` rows of the file stand before them."""
    if column.width is None:
        return cells
    sizes = [len(cell) if cell.is_valid else 0 for cell in cells] if cells.null_count else cells.value_lengths()
    wrong = np.flatnonzero(np.asarray(sizes) != column.width)
    if wrong.size:
        where = f"row {row + int(wrong[0]) + 1}, column {column.name}"
        raise LogError(str(path), where, f"{sizes[int(wrong[0])]} numbers", f"{column.width}, as in the first row")
    return cells.flatten()[column.place :: column.width]


def _numbers(path: Path, name: str, cells: Any) -> Array:
    try:
        return np.asarray(cells.to_numpy(zero_copy_only=False), dtype=np.float64)
    except (TypeError, ValueError):
        raise LogError(str(path), f"column {name}", f"of type {cells.type}", "numbers") from None


def _parquet_file(path: Path) -> Any:
    parquet = _pyarrow()[1]
    try:
        return parquet.ParquetFile(path)
    except Exception:  # ArrowInvalid, ArrowNotImplementedError, OSError: a damaged file
        raise _not_whole(path) from None


def _not_whole(path: Path) -> FileAccessError:
    return FileAccessError(str(path), "not a whole Parquet file", "a log (.csv or .parquet)")


def _pyarrow() -> tuple[Any, Any]:
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise MissingPackageError("pyarrow", "logs") from None
    return pyarrow, parquet


NOTES = "lwr_dyn.notes"
"""Key in the metadata of a Parquet file: lines about its content."""


def table_bytes(names: Sequence[str], columns: Sequence[Array], suffix: str, notes: Sequence[str] = ()) -> bytes:
    """Columns as the bytes of a CSV or Parquet file, every float to its last bit; raises `MissingPackageError`.

    `notes` stand in lines with `#` above the names, or under `NOTES` in the metadata of Parquet.
    """
    if suffix == ".parquet":
        pyarrow, parquet = _pyarrow()
        sink = pyarrow.BufferOutputStream()
        table = pyarrow.table(dict(zip(names, columns, strict=True)))
        parquet.write_table(table.replace_schema_metadata({NOTES: "\n".join(notes)} if notes else None), sink)
        return bytes(sink.getvalue().to_pybytes())
    rows = (",".join(map(repr, row)) for row in zip(*(c.tolist() for c in columns), strict=True))
    return ("\n".join([*(f"# {note}" for note in notes), ",".join(names), *rows]) + "\n").encode()
