# SPDX-License-Identifier: BSD-2-Clause
"""Tables of a benchmark: columns as its file states them, rows from the flights that belong together."""
import dataclasses
import re
import statistics

from bench.benchmark_lib import number
from bench.figures import figure_of, rms_of
from bench.plan import Condition, PlanError, as_list, known
from bench.stats import geometric_mean, quantile, with_interval

PLACE = ("condition", "sequence", "case", "mode")
AXES = (*PLACE, "seed")
HEADS = {"condition": "K"}
RELATIONS = ("at", "over", "minus")
TABLE_KEYS = {"title", "rows", "only", "columns", "document"}


def by_sequence(values, always=False):
    """Geometric means over each sequence's flights, if there are several sequences, or always; else the values."""
    groups = {}
    for flight, value in values:
        if value > 0:
            groups.setdefault(flight.sequence, []).append(value)
    means = [geometric_mean(group)[0] for group in groups.values()]
    return means if always or len(means) > 1 else [value for group in groups.values() for value in group]


def plain(function):
    """A figure of values without their flights; None of none."""
    return lambda values: function([value for _, value in values]) if values else None


HOWS = {
    "median": plain(statistics.median), "mean": plain(statistics.fmean), "worst": plain(max), "least": plain(min),
    "sum": plain(sum), "rms": plain(rms_of), "p95": plain(lambda values: quantile(values, 0.95)),
    "count": plain(len), "geometric": lambda values: geometric_mean(by_sequence(values))[0],
    "interval": by_sequence,  # written as mean [low, high]
    "worst_sequence": lambda values: max(by_sequence(values, True), default=None),
    "each": plain(lambda values: "/".join(dict.fromkeys(map(str, values)))), "missing": None, "flights": None,
}
PAIRED = ("geometric", "interval", "worst", "worst_sequence", "rms", "count")


@dataclasses.dataclass(frozen=True)
class Column:
    """One column: `how` over the flights of a row, of a figure, perhaps against the same at other places of axes."""
    head: str
    how: str
    figure: str
    relation: str
    places: tuple   # of axes: (axis, value)
    digits: int
    most: float     # limits of a good row; None: none
    least: float

    @staticmethod
    def of(entry, figures):
        """A column of a file: [head, "how figure relation axis=value,...", digits, {most: ..., least: ...}]."""
        if not isinstance(entry, list) or not 2 <= len(entry) <= 4:
            raise PlanError(f"column {entry}: must be [head, what, digits, limits]")
        head, what, digits, limits = (*entry, *([0, {}][len(entry) - 2:]))
        known(limits, {"most", "least"}, f"column {head}")
        words = str(what).split()
        how = words.pop(0) if words[0] in HOWS else "median"
        figure = words.pop(0) if words and words[0] not in RELATIONS else "ate_mm"
        relation = words.pop(0) if words and words[0] in RELATIONS else ""
        places = tuple(tuple(part.split("=", 1)) for part in re.split(r",(?=\w+=)", " ".join(words)) if part)
        if figure not in figures:
            raise PlanError(f"column {head}: unknown figure '{figure}'")
        if bool(relation) != bool(places) or any(len(place) != 2 or place[0] not in PLACE for place in places):
            raise PlanError(f"column {head}: '{what}' must be [HOW] FIGURE [at|over|minus AXIS=VALUE,...]")
        places = tuple((axis, Condition.of(value) if axis == "condition" else value) for axis, value in places)
        return Column(str(head), how, figure, relation, places, int(digits), limits.get("most"), limits.get("least"))


class Tables:
    """The tables of a plan over its flights' runs."""

    def __init__(self, plan, figures):
        self.plan, self.figures = plan, figures
        self.runs, self.draws = {}, {}  # flights by all axes but the seed, then by it
        self.tables = {}
        for name, entry in (plan.content.get("tables") or {}).items():
            known(entry, TABLE_KEYS, f"tables.{name}")
            rows = [axis if isinstance(axis, dict) else {axis: HEADS.get(axis, axis)} for axis in entry.get("rows", [])]
            axes = {axis: head for row in rows for axis, head in row.items()}
            known(axes, AXES, f"tables.{name}.rows")
            known(entry.get("only") or {}, AXES, f"tables.{name}.only")
            self.tables[name] = (axes, {axis: as_list(values) for axis, values in (entry.get("only") or {}).items()},
                                 [Column.of(column, figures) for column in entry["columns"]])

    def value(self, flight, figure):
        return figure_of(self.runs.get(flight), self.figures[figure])

    def elsewhere(self, flight, places):
        """The flight at other places of axes: with the same seed, or the only one there is."""
        draws = self.draws.get(tuple(dict(places).get(axis, getattr(flight, axis)) for axis in PLACE), {})
        return draws.get(flight.seed, next(iter(draws.values())) if len(draws) == 1 else None)

    def values(self, column, group, relation):
        """(flight, value) of a row's flights that have the figure, by themselves, elsewhere, or against elsewhere."""
        found = []
        for flight in group:
            own = self.value(flight, column.figure)
            if relation:
                other = self.elsewhere(flight, column.places)
                there = self.value(other, column.figure) if other else None
                own = (there if relation == "at" else None if own is None or there is None
                       else own - there if relation == "minus" else own / there if there else None)
            if own is not None:
                found.append((flight, own))
        return found

    def cell(self, column, group):
        """(text, value) of a column for the flights of a row."""
        if column.how == "missing":
            value = sum(self.value(flight, column.figure) is None for flight in group)
        elif column.how == "flights":  # sequences x draws
            counts = {}
            for flight, _ in self.values(column, group, ""):
                counts[flight.sequence] = counts.get(flight.sequence, 0) + 1
            same = len(set(counts.values())) == 1
            value = f"{len(counts)} x {next(iter(counts.values()))}" if same else " + ".join(map(str, counts.values()))
        elif column.relation == "over" and column.how not in PAIRED:
            values = [HOWS[column.how](self.values(column, group, relation)) for relation in ("", "at")]
            value = values[0] / values[1] if None not in values and values[1] else None
        else:
            value = HOWS[column.how](self.values(column, group, column.relation))
        if column.how == "interval":
            return with_interval(value, column.digits) or "-", geometric_mean(value)[0]
        return value if isinstance(value, str) else number(value, column.digits), value

    def build(self, name, runs):
        """Heads, rows, number of columns of text, and sentences about limits that are exceeded."""
        self.runs = runs
        self.draws = {}
        for flight in runs:
            self.draws.setdefault(tuple(getattr(flight, axis) for axis in PLACE), {})[flight.seed] = flight
        axes, only, columns = self.tables[name]
        groups, rows, broken = {}, [], []
        for flight in runs:
            place = {axis: str(getattr(flight, axis)) for axis in AXES}
            wanted = {axis: [str(Condition.of(v)) if axis == "condition" else str(v) for v in values]
                      for axis, values in only.items()}
            if all(place[axis] in values for axis, values in wanted.items()):
                groups.setdefault(tuple(place[axis] for axis in axes), []).append(flight)
        for place, group in groups.items():
            cells = [self.cell(column, group) for column in columns]
            rows.append([*place, *(text for text, _ in cells)])
            for column, (text, value) in zip(columns, cells):
                if isinstance(value, (int, float)) and ((column.most is not None and value > column.most) or
                                                        (column.least is not None and value < column.least)):
                    bound = f"at most {column.most:g}" if column.most is not None else f"at least {column.least:g}"
                    broken.append(f"limit: {', '.join(place)}: {column.head} {text}, target {bound}")
        return [*axes.values(), *(column.head for column in columns)], rows, len(axes), broken
