"""Records: named floats that the kernel reads and writes, compiled or not.

A schema maps a field to ``None`` (a float) or to another schema. The compiled
kernel sees a numpy structured array, the interpreted one plain objects with the
same field names; both index it with ``[0]`` first, so kernel code is one.
"""

from __future__ import annotations

import copy
import functools
from collections.abc import Iterable, Mapping
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

Schema = Mapping[str, Any]

APART = 128
"""Bytes between what two threads write. [B]"""


def floats(*names: str) -> dict[str, None]:
    """Return the schema of a flat record of floats."""
    return dict.fromkeys(names)


class Rows(list[Any]):
    """Interpreted array of records: assigning a row copies it, as numpy does."""

    def __setitem__(self, index: Any, value: Any) -> None:
        """Copy ``value`` into row ``index``."""
        super().__setitem__(index, copy.copy(value))


def dtype_of(schema: Schema) -> np.dtype[Any]:
    """Return the numpy dtype of a schema."""
    import numpy as np

    return np.dtype(
        [(k, "f8" if v is None else dtype_of(v)) for k, v in schema.items()]
    )


def array(schema: Schema, rows: int = 1) -> np.ndarray[Any, Any]:
    """Return zeroed records for the compiled kernel."""
    import numpy as np

    return np.zeros(rows, dtype_of(schema))


def arrays(kinds: Iterable[np.dtype[Any]]) -> list[np.ndarray[Any, Any]]:
    """Return one zeroed record of each kind, all of them apart from any others.

    What one thread writes at every step must not share a cache line with what another
    does: each would wait for the other. A CPU may fetch two lines at once.
    """
    import numpy as np

    kinds = list(kinds)
    whole = sum(kind.itemsize for kind in kinds)
    room = np.zeros(whole + 2 * APART, np.uint8)
    at = -room.ctypes.data % APART
    found = []
    for kind in kinds:
        found.append(room[at : at + kind.itemsize].view(kind))
        at += kind.itemsize
    return found


def plain(schema: Schema, rows: int = 1) -> Rows:
    """Return zeroed records for the interpreted kernel."""
    return Rows(_plain(schema) for _ in range(rows))


def fill(records: Any, values: Mapping[str, Mapping[str, float]]) -> None:
    """Write tables of values into the first record, of either kind; 0 where none is."""
    if isinstance(records, Rows):
        for name, table in values.items():
            inner = getattr(records[0], name)
            for key, value in table.items():
                setattr(inner, key, float(value))
        return
    # all at once: each assignment is dear
    places = [(values.get(name, {}), keys) for name, keys in _keys(records.dtype)]
    whole = [table.get(key, 0.0) for table, keys in places for key in keys]
    records[:1].view(float)[:] = whole


@functools.cache
def _keys(kind: np.dtype[Any]) -> list[tuple[str, tuple[str, ...]]]:
    """Return the tables of a kind of record, each with its keys."""
    return [(name, kind[name].names or ()) for name in kind.names or ()]


def column(records: Any, field: str) -> np.ndarray[Any, Any]:
    """Return one field of all records as a float array."""
    import numpy as np

    if isinstance(records, Rows):
        return np.array([getattr(row, field) for row in records], dtype=float)
    return np.ascontiguousarray(records[field])


def _plain(schema: Schema) -> SimpleNamespace:
    items: Iterable[tuple[str, Any]] = schema.items()
    return SimpleNamespace(**{k: 0.0 if v is None else _plain(v) for k, v in items})
