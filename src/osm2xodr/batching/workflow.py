"""The steps of a batch: find out which areas have changed, cut them out, convert them, record what was made."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import Final, Protocol

from osm2xodr.batching.area_process import AreaJob, Outcome
from osm2xodr.batching.area_rows import thumbnail
from osm2xodr.batching.areas import PlannedArea, road_bounds, shared_frame
from osm2xodr.batching.kept_cuts import (
    KeptCuts,
    Mark,
    Marks,
    State,
    contents,
    cut_name,
    load_state,
    remove,
    save_state,
)
from osm2xodr.batching.model import Result, Status, for_batches
from osm2xodr.batching.out_dir import OutDir, write_if_changed
from osm2xodr.batching.workers import Workers, running
from osm2xodr.diagnostics import Diagnostics
from osm2xodr.errors import Osm2xodrError, SwappedAxesError
from osm2xodr.model import Corrections, unused
from osm2xodr.surface import is_virtual, virtual_sources
from osm2xodr.system import parse_json, record, uninterrupted

# Options that do not change the result of a conversion; each has a value.
_BOUNDS: Final = frozenset({"--max-memory", "--timeout"})


@record
class BatchOptions:
    """How a batch is made."""

    workers: Workers
    timeout: float | None = None  # Time that an area may take, s; None for no bound
    shared: bool = False  # Whether all areas share the frame of the first one, and their roads meet at borders
    force: bool = False  # Whether areas are made that have not changed
    corrections_file: Path | None = None  # Corrections for all areas, and what it says
    corrections: Corrections = field(default_factory=Corrections)
    surroundings: bool = False  # Whether cuts have the buildings and the water of scenes as well
    own: frozenset[str] = frozenset()  # Names of the options of the command itself, such as ``--workers``


class Listener(Protocol):
    """Is called as a batch goes on."""

    def stage(self, name: str) -> None:
        """Take the name of the stage that begins."""

    def begin(self, areas: int) -> None:
        """Take the number of all areas, as the batch begins."""

    def settle(self, ended: int, failed: int) -> None:
        """Take how many areas need no conversion so far, and how many of these failed."""

    def convert(self, weights: Sequence[float]) -> None:
        """Take the areas that are to be converted, as estimates of the time that each takes, in any unit."""

    def end(self, result: Result, weight: float) -> None:
        """Take the result of one of them."""


class _Batch:
    """A batch that runs."""

    def __init__(self, planned: Sequence[PlannedArea], out: OutDir, options: BatchOptions) -> None:
        self.out = out
        self.options = options
        self.results: dict[str, Result] = {}
        self.marks = Marks()
        self._cuts = KeptCuts(out, options.corrections, planned, context=options.shared, scenes=options.surroundings)
        self._sources: dict[Path, list[Path]] = {}
        found = {item.area.name: load_state(out.state(item.area.name)) for item in planned}
        self.states = {name: state for name, state in found.items() if state is not None}
        self.marks.learn(self.states.values())
        self.planned = self._as_before(planned)

    def _as_before(self, planned: Sequence[PlannedArea]) -> list[PlannedArea]:
        """Return the areas, those of blocks of which some were made by themselves without their block."""
        by_themselves = set[str]()
        for item in planned:
            state = self.states.get(item.area.name)
            if item.block is not None and state is not None and state.outputs and "--tile" not in state.arguments:
                alone = replace(item, block=None)
                if self.unchanged(state, self.wanted(alone)):
                    by_themselves.add(item.block.name)
        return [
            replace(item, block=None) if item.block is not None and item.block.name in by_themselves else item
            for item in planned
        ]

    def arguments(self, item: PlannedArea) -> tuple[str, ...]:
        """Return the arguments of ``osm2xodr`` that make an area."""
        area = item.area
        xodr, report = self.out.outputs(area.name)
        dems = [word for dem in area.dems for word in ("--dem", _plain(dem))]
        frame = ["--frame", _plain(self.out.frame)] if self.options.shared else []
        frame += ["--tile", area.name] if item.block is not None else []
        limit = ["--timeout", f"{self._timeout(item):g}"] if self.options.timeout is not None else []
        known = self.options.corrections_file
        corrections = [] if known is None else ["--corrections", _plain(known), "--corrections-shared"]
        fixed = ["--name", area.name, "--overwrite", "--quiet", "--jobs", "1", *limit, *frame, *area.options]
        files = [_plain(self._map(item)), *dems, "-o", _plain(xodr), "--report-json", _plain(report), *corrections]
        return ("convert", *files, *fixed)

    def _timeout(self, item: PlannedArea) -> float:
        """Return the time that an area may take, s: whichever comes first lays out all areas of its block."""
        many = 1 if item.block is None else len(self._cuts.names(item.block))
        return many * (self.options.timeout or 0.0)

    def _map(self, item: PlannedArea) -> Path:
        """Return the file that an area is converted from."""
        return self.out.cut(cut_name(item)) if item.outline is not None else item.area.osm

    def wanted(self, item: PlannedArea) -> State | None:
        """Return the state that an area made now would have, without cut and outputs; None without a file."""
        dems = [path for dem in item.area.dems for path in (dem, *self.sources(dem))]
        known = self.options.corrections_file
        inputs = [*dems, *([self.out.frame] if self.options.shared else []), *([] if known is None else [known])]
        cut_from, how = None, ""
        if item.outline is None:
            inputs.insert(0, item.area.osm)
        else:
            cut_from, how = self.marks.of(item.area.osm), self._cuts.how(item)
            if cut_from is None:
                return None
        marks = self.marks.of_all(inputs)
        return None if marks is None else State(_unbounded(self.arguments(item)), marks, cut_from, how)

    def sources(self, dem: Path) -> list[Path]:
        """Return the rasters that a virtual elevation model refers to."""
        if dem not in self._sources:
            try:
                self._sources[dem] = virtual_sources(dem) if is_virtual(dem) else []
            except (OSError, Osm2xodrError):
                # The conversion will report what is wrong with it.
                self._sources[dem] = []
        return self._sources[dem]

    def unchanged(self, state: State | None, wanted: State | None) -> bool:
        """Return whether an area was made of the same input, apart from its cut, and its files are still there."""
        if state is None or wanted is None or self.options.force:
            return False
        made, now = ((one.version, one.arguments, contents(one.inputs)) for one in (state, wanted))
        return made == now and all(self.marks.same(mark) for mark in state.outputs)

    def settle(self, item: PlannedArea, status: Status, message: str = "", outcome: Outcome | None = None) -> Result:
        """Record the result of an area."""
        name = item.area.name
        outline = item.area.outline_deg
        if not outline and status in (Status.DONE, Status.UNCHANGED):
            outline = road_bounds(self.out.outputs(name)[0])
        seconds, memory = (outcome.seconds, outcome.memory) if outcome is not None else (0.0, 0)
        self.results[name] = Result(name, status, for_batches(message, self.options.own), seconds, memory, outline)
        return self.results[name]

    def changed(self) -> list[PlannedArea]:
        """Settle areas that have not changed, and return the others."""
        left = []
        for item in self.planned:
            state, wanted = self.states.get(item.area.name), self.wanted(item)
            same = self.unchanged(state, wanted)
            if same and state is not None and wanted is not None and _same_cutting(state, wanted):
                self._keep(item, state)
                # Files may have been written again with the same contents: recorded, they need not be read once more.
                if (state.inputs, state.cut_from) != (wanted.inputs, wanted.cut_from):
                    self._save(item, replace(wanted, cut=state.cut, outputs=state.outputs))
            else:
                left.append(item)
        return left

    def cut(self, items: Sequence[PlannedArea]) -> list[PlannedArea]:
        """Cut areas out; settle those that are empty or whose cut has not changed, and return the others."""
        self._cuts.clear([] if self.options.force else [cut_name(item) for item in self.planned])
        return self._left_of(items, self._cut_all(items))

    def cut_apart(self, items: Sequence[PlannedArea]) -> list[PlannedArea]:
        """Cut areas out of the cuts of their blocks; settle some as `cut` does, and return the others."""
        counts: dict[str, int] = {}
        blocks: dict[str, list[PlannedArea]] = {}
        for item in items:
            blocks.setdefault(cut_name(item), []).append(replace(item, block=None))
        for name, parts in blocks.items():
            counts.update(self._cut_source(parts[0].area.osm, parts, self.out.cut(name)))
        return self._left_of([replace(item, block=None) for item in items], counts)

    def _cut_all(self, items: Sequence[PlannedArea]) -> dict[str, int]:
        """Cut areas out, and return the number of ways that become streets in each."""
        sources: dict[Path, list[PlannedArea]] = {}
        for item in items:
            if item.outline is not None:
                sources.setdefault(item.area.osm, []).append(item)
        counts: dict[str, int] = {}
        for source, parts in sources.items():
            counts.update(self._cut_source(source, parts))
        return counts

    def _left_of(self, items: Sequence[PlannedArea], counts: Mapping[str, int]) -> list[PlannedArea]:
        """Settle areas without streets and those whose cut has not changed, and return the others."""
        left = []
        for item in items:
            name = item.area.name
            if item.outline is None or (name in counts and not self._settle_cut(item, counts[name])):
                left.append(item)
        return left

    def _cut_source(self, source: Path, parts: Sequence[PlannedArea], out_of: Path | None = None) -> dict[str, int]:
        mark = self.marks.of(source)
        try:
            # Without a mark it cannot be read, which is then said.
            return self._cuts.make(source, mark or Mark(str(source), 0, 0, ""), parts, out_of)
        except SwappedAxesError:
            # The list of areas is wrong, which may concern more of them than this one.
            raise
        except Osm2xodrError as error:
            for item in parts:
                self._drop(item)
                self.settle(item, Status.FAILED, str(error))
            return {}

    def _settle_cut(self, item: PlannedArea, ways: int) -> bool:
        """Settle an area if it is empty or its cut has not changed; return whether it is settled."""
        name = item.area.name
        state, wanted = self.states.get(name), self.wanted(item)
        if ways == 0:
            self._drop(item)
            if wanted is not None:
                self._save(item, wanted)
            self.settle(item, Status.EMPTY, _nothing(item))
            return True
        mark = self.marks.of(self._map(item))
        same = state is not None and state.cut is not None and mark is not None and state.cut.sha256 == mark.sha256
        if not (same and self.unchanged(state, wanted)) or state is None or wanted is None:
            return False
        self._save(item, replace(wanted, cut=mark, outputs=state.outputs))
        self._keep(item, state)
        return True

    def tell(self, listener: Listener) -> None:
        """Say how many areas have ended."""
        listener.settle(len(self.results), sum(item.status is Status.FAILED for item in self.results.values()))

    def convert(self, items: Sequence[PlannedArea], listener: Listener) -> list[PlannedArea]:
        """Convert areas, those with the largest maps first; return those that their block cannot be laid out for."""
        weights, size = self._weights(items)
        by_name = {item.area.name: item for item in items}
        # Read first: if a file changes meanwhile, the next run makes the area anew.
        wanted = {item.area.name: self.wanted(item) for item in items}
        # The areas of a block follow each other.
        order = sorted(by_name, key=lambda name: (-size[cut_name(by_name[name])], cut_name(by_name[name])))
        jobs = [AreaJob(name, self.arguments(by_name[name]), block=_block(by_name[name])) for name in order]
        apart = []
        listener.convert([weights[name] for name in order])
        with running(jobs, self.options.workers) as outcomes:
            for job, outcome in outcomes:
                item = by_name[job.name]
                if outcome.apart and not self._partly_made(item):
                    apart.append(item)
                    continue
                with uninterrupted():
                    result = self._made(item, wanted[job.name], outcome)
                listener.end(result, weights[job.name])
        return apart

    def _partly_made(self, item: PlannedArea) -> bool:
        """Say whether areas of a block were made with it: others would not fit to them if they were made apart."""
        names = self._cuts.names(item.block) if item.block is not None else ()
        return any(
            result.status in (Status.DONE, Status.UNCHANGED)
            for result in (self.results[name] for name in names if name in self.results)
        )

    def _made(self, item: PlannedArea, wanted: State | None, outcome: Outcome) -> Result:
        name = item.area.name
        if outcome.empty and item.outline is not None:
            cut = self.marks.of(self._map(item))
            self._drop(item)
            if wanted is not None:
                self._save(item, replace(wanted, cut=cut))
            return self.settle(item, Status.EMPTY, _nothing(item), outcome)
        outputs = self.marks.of_all(self.out.outputs(name))
        if outcome.message or outputs is None:
            self._drop(item)
            return self.settle(item, Status.FAILED, outcome.message or "its files are gone", outcome)
        if wanted is not None:
            cut = self.marks.of(self._map(item)) if item.outline is not None else None
            self._save(item, replace(wanted, cut=cut, outputs=outputs))
        # Now, while others are converted, and not for all of them at the end.
        thumbnail(self.out, name)
        return self.settle(item, Status.DONE, "", outcome)

    def _keep(self, item: PlannedArea, state: State) -> None:
        if state.outputs:
            self.settle(item, Status.UNCHANGED)
        else:
            self.settle(item, Status.EMPTY, _nothing(item))

    def _drop(self, item: PlannedArea) -> None:
        """Remove the results of an area that cannot be made: those of an earlier run are of other input."""
        name = item.area.name
        remove(self.out.state(name), self.out.thumbnail(name), *self.out.outputs(name))

    def _save(self, item: PlannedArea, state: State) -> None:
        save_state(self.out.state(item.area.name), state)

    def _weights(self, items: Sequence[PlannedArea]) -> tuple[dict[str, float], dict[str, float]]:
        """Return an estimate of the time that each area takes, and the size of each map, by the name of its cut."""
        marks = {cut_name(item): self.marks.of(self._map(item)) for item in items}
        size = {name: 1.0 if mark is None else 1.0 + mark.size for name, mark in marks.items()}
        many = Counter(map(cut_name, items))
        return {item.area.name: size[cut_name(item)] / many[cut_name(item)] for item in items}, size


def run_batch(
    planned: Sequence[PlannedArea], out: OutDir, options: BatchOptions, diagnostics: Diagnostics, listener: Listener
) -> list[Result]:
    """Make all areas that are missing or have changed, and return the result of each, in their order.

    Each area has another name; `out` is locked for this batch, and `diagnostics` receives a note on files of areas
    that are no longer in it. What is wrong with one area is its result; `Osm2xodrError` is raised where nothing can
    be converted: there is no Dask where one is asked for, or nothing can be written.
    """
    listener.begin(len(planned))
    listener.stage("looking for changes")
    if options.shared:
        write_if_changed(out.frame, shared_frame(planned))
    batch = _Batch(planned, out, options)
    left = batch.changed()
    batch.tell(listener)
    if left:
        # They are unfinished until they are made.
        remove(*(out.state(item.area.name) for item in left))
        if any(item.outline is not None for item in left):
            listener.stage("cutting out areas")
            left = batch.cut(left)
            batch.tell(listener)
    if left:
        listener.stage("starting workers")
        apart = batch.convert(left, listener)
        if apart:
            listener.stage("cutting out areas")
            left = batch.cut_apart(apart)
            batch.tell(listener)
            batch.convert(left, listener)
    old = sorted(set(out.known()) - {item.area.name for item in planned})
    if old:
        more = f" and {len(old) - 3:,} more" if len(old) > 3 else ""
        sentence = f"files of areas that are no longer in the batch stay: {', '.join(old[:3])}{more}"
        diagnostics.note("old-areas", "", sentence)
    results = [batch.results[item.area.name] for item in planned]
    if not any(result.status is Status.FAILED for result in results):
        _report_unused(options.corrections, [out.outputs(result.name)[1] for result in results], diagnostics)
    return results


def _report_unused(corrections: Corrections, reports: Sequence[Path], diagnostics: Diagnostics) -> None:
    """Report corrections that none of the areas with these reports has applied."""
    wanted = list(corrections.entries())
    found = set[tuple[str, str]]() if not wanted else {item for path in reports for item in _applied(path)}
    for osm_id, key in wanted:
        if (osm_id, key) not in found:
            unused(diagnostics, osm_id, key, "it matches nothing in any area, or changes nothing there")


def _applied(report: Path) -> Iterator[tuple[str, str]]:
    """Yield element and key of the corrections that were applied by a report; an area without roads has none."""
    try:
        found = parse_json(report.read_bytes())["diagnostics"]
        applied = [(item["osm_id"], item["message"]) for item in found if item["code"] == "correction"]
    except (OSError, ValueError, LookupError, TypeError):
        return  # The index of the batch says so
    yield from ((osm_id, message.partition(":")[0]) for osm_id, message in applied)


def _plain(path: Path) -> str:
    """Return a path as text that is not taken for an option."""
    text = str(path)
    return f"./{text}" if text.startswith("-") else text


def _unbounded(arguments: Sequence[str]) -> tuple[str, ...]:
    """Leave out the options that only bound memory and time."""
    bound = {k + step for k, word in enumerate(arguments) if word in _BOUNDS for step in (0, 1)}
    return tuple(word for k, word in enumerate(arguments) if k not in bound)


def _same_cutting(state: State, wanted: State) -> bool:
    """Return whether two states were cut out of the same file in the same way, or were not cut out."""
    sources = [mark.sha256 if mark is not None else "" for mark in (state.cut_from, wanted.cut_from)]
    return sources[0] == sources[1] and state.cut_how == wanted.cut_how


def _block(item: PlannedArea) -> str:
    """Return the name of the block that an area is made with; empty for none."""
    return "" if item.block is None else item.block.name


def _nothing(item: PlannedArea) -> str:
    return f"there is nothing to drive on in this part of {item.area.osm}"
