"""Columns of words: what a map reads of them, and what becomes of them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from rcc_sim.readers.build import Column
from rcc_sim.readers.column_map import CLOCK, DATE, ColumnMap, Term
from rcc_sim.readers.log import Array
from rcc_sim.readers.words import carried, clock_seconds, date_seconds

SECONDS = {CLOCK: clock_seconds, DATE: date_seconds}
"""Unit of a time that is written as words -> what makes seconds of them."""


def read_as_words(by: ColumnMap, wanted: Iterable[str]) -> set[str]:
    """Return which of some columns a map reads as words, not as numbers."""
    if by.carry_tenths:
        return set(wanted)
    found: set[str] = set()
    for term in _terms(by):
        if term.unit in SECONDS:
            found.update(term.sources)
        for where in (term.blank_where, term.negative_where):
            if where and not where.equals.lstrip("-").replace(".", "", 1).isdigit():
                found.add(where.source)
    return found & set(wanted)


def column_of(
    by: ColumnMap, name: str, values: Array | list[str], where: str
) -> Column:
    """Return a column as read: numbers, words that a map makes numbers of, or words.

    Raises
    ------
    InputError
        Naming ``where``, column and row of a word that is no time.
    """
    if not isinstance(values, list):
        return Column(values)
    for term in _terms(by):
        if name in term.sources and term.unit in SECONDS:
            return Column(SECONDS[term.unit](values, f"{where}: {name}"))
    if by.carry_tenths:
        return Column(carried(values, f"{where}: {name}"))
    return Column(np.full(len(values), np.nan), words=values)


def _terms(by: ColumnMap) -> Iterable[Term]:
    return (term for terms in by.columns.values() for term in terms)
