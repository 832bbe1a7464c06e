"""Where traffic can go: from lane to lane, along roads and through junctions."""

from __future__ import annotations

import numpy as np

from osm2xodr.checking.checks import lane_index, transitions
from osm2xodr.checking.findings import Findings
from osm2xodr.curves import unique_rows
from osm2xodr.model import BoolArray, IntArray
from osm2xodr.opendrive import ABSENT, End, OpenDrive
from osm2xodr.system import record


@record(eq=False)
class Driving:
    """The graph of lanes that cars drive on.

    A node is a lane in a direction: twice its row, plus 1 against s.
    """

    # (lanes,) Whether cars drive on the lane along s, and against s
    along: BoolArray
    against: BoolArray
    # (steps,) Nodes: from the end of one to the beginning of the other; each pair once, in order
    start: IntArray
    end: IntArray


def contacts_of(drive: OpenDrive) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Return all links of a file from lane to lane, whatever their types.

    They are lane (a row), `End` of it, the other lane and its `End`, (n,) each, as often as the file states them;
    links that lead nowhere are left out.
    """
    lanes, table = lane_index(drive), drive.lanes
    across = transitions(drive, lanes, Findings(drive, frozenset()))
    parts = [(across.lane_a, across.end_a, across.lane_b, across.end_b)]
    for end, ids in ((End.START, table.predecessor), (End.END, table.successor)):
        row = np.flatnonzero(~lanes.is_outermost(table.section, end) & (ids != ABSENT))
        other = lanes.find(table.section[row] + (1 if end else -1), ids[row])
        row, other = row[other >= 0], other[other >= 0]
        parts.append((row, np.full(len(row), end), other, np.full(len(row), 1 - end)))
    a, end_a, b, end_b = (np.concatenate(columns).astype(np.int64) for columns in zip(*parts, strict=True))
    return a, end_a, b, end_b


def driving_of(drive: OpenDrive) -> Driving:
    """Return where cars can go in a file; links that lead nowhere, or against traffic, are left out."""
    lanes = lane_index(drive)
    along = lanes.driving & (lanes.forward | lanes.both_ways)
    against = lanes.driving & (~lanes.forward | lanes.both_ways)
    a, end_a, b, end_b = contacts_of(drive)
    # Each link is a step for the traffic of either direction.
    one, other = np.concatenate((a, b)), np.concatenate((b, a))
    leaves_back = np.concatenate((end_a, end_b)) == End.START
    enters_back = np.concatenate((end_b, end_a)) == End.END
    open_ = np.where(leaves_back, against[one], along[one]) & np.where(enters_back, against[other], along[other])
    pairs = np.stack((2 * one + leaves_back, 2 * other + enters_back), axis=1)[open_]
    steps = unique_rows(pairs).values
    return Driving(along, against, steps[:, 0], steps[:, 1])
