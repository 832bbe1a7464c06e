"""What a conversion comes to, in ten lines at most."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import Enum
from typing import TYPE_CHECKING, Final

from osm2xodr.diagnostics import Diagnostics, Kind, counted
from osm2xodr.reporting.report import codes, example
from osm2xodr.system import record
from osm2xodr.xodrWriter import plan_view_bounds

if TYPE_CHECKING:
    from osm2xodr.reporting.conversion import Conversion

# Of all lines with the one that says what was written; a summary is read at a glance.
_LINES_MOST: Final = 10
# Longest text of a line that needs attention; one more would be cut by most terminals with what stands before.
_TEXT_MOST: Final = 120
# Where findings of `check` stand among what needs attention: after roads that meet each other.
_HARM_OF_CHECK: Final = 30
_KINDS: Final[Sequence[Kind]] = (Kind.GUESSED, Kind.DROPPED, Kind.REPAIRED, Kind.NOTE)


class Style(Enum):
    """How a line is meant, for terminals with colours."""

    PLAIN = "plain"
    HEADING = "heading"
    ATTENTION = "attention"


@record
class Line:
    """A line of a summary."""

    text: str
    style: Style = Style.PLAIN


@record
class Summary:
    """What is said about a conversion, without its data."""

    made: tuple[str, ...]  # What was made, and its heights
    attention: tuple[tuple[int, str], ...]  # What needs attention, by harm
    counts: str  # How much was guessed, dropped and repaired

    def lines(self, findings: int = 0, used: int = 1, more: str = "--report-json, -v") -> list[Line]:
        """Return the lines: what needs attention in order of harm, what was made, how much was guessed.

        `findings` is the number of errors and warnings of `check`, `used` that of lines that were said before: all
        together are ten at most. `more` are the options that say the guesses one by one.
        """
        ranked = list(self.attention)
        if findings:
            words = f"check: {counted(findings, 'finding')}, listed above"
            ranked.append((_HARM_OF_CHECK, words))
        texts = [text for _, text in sorted(ranked, key=lambda item: item[0])]
        # The heading and the last line are two more.
        most = _LINES_MOST - used - len(self.made) - 2
        if len(texts) > most:
            texts = [*texts[: most - 1], f"and {counted(len(texts) - most + 1, 'kind')} more: -v"]
        heading = [Line("needs attention (osm2xodr explain CODE says more):", Style.HEADING)] if texts else []
        shown = [Line(f"  {text}", Style.ATTENTION) for text in texts]
        return [*heading, *shown, *(Line(f"  {text}") for text in self.made), Line(f"{self.counts}: {more}")]


def summary(conversion: Conversion, diagnostics: Diagnostics, *, has_heights: bool) -> Summary:
    """Sum up a conversion.

    `diagnostics` are those of the conversion with what the version of OpenDRIVE cannot say; `has_heights` says
    whether there is an elevation model.
    """
    counts = dict.fromkeys(Kind, 0)
    for (kind, _), count in diagnostics.counts().items():
        counts[kind] += count
    guesses = f"{counts[Kind.GUESSED]:,} guess{'' if counts[Kind.GUESSED] == 1 else 'es'}"
    rest = f"{counts[Kind.DROPPED]:,} dropped, {counts[Kind.REPAIRED]:,} repaired"
    made = tuple(_made(conversion, has_heights=has_heights))
    return Summary(made, tuple(_attention(diagnostics)), f"{guesses}, {rest}")


def _made(conversion: Conversion, *, has_heights: bool) -> list[str]:
    """Return what was made, in two lines."""
    figures, road_map = conversion.statistics, conversion.road_map
    lights = int(figures.further.get("traffic_lights", 0))
    built = [item.kind for item in road_map.elevation_report.structures] if road_map.elevation_report else []
    parts = [
        f"{figures.road_length / 1e3:,.1f} km of road",
        counted(figures.junctions, "junction"),
        *(counted(built.count(kind), kind) for kind in ("bridge", "tunnel") if kind in built),
        *([counted(lights, "traffic light")] if lights else []),
    ]
    west, south, east, north = plan_view_bounds(road_map.plan_view)
    extent = f"{(east - west) / 1e3:,.1f} x {(north - south) / 1e3:,.1f} km"
    side = "left" if road_map.rule.value == "LHT" else "right"
    place = f"{road_map.country or 'outside of all countries'}, {extent}, traffic on the {side}"
    if not has_heights:
        flat = "flat at height 0: there is no elevation model"
        if road_map.elevation_report is not None:
            flat += f"; bridges and tunnels, with their ramps, from {figures.lowest:,.1f} to {figures.highest:,.1f} m"
        return [f"{', '.join(parts)}; {place}", flat]
    heights = f"heights from {figures.lowest:,.1f} to {figures.highest:,.1f} m"
    if figures.dem_coverage is not None:
        heights += f", measured on {percent(figures.dem_coverage)} of the roads"
    if (found := road_map.elevation_report) is not None:
        heights += f"; 95 % of the ground within {found.p95:.2f} m of the elevation model"
    return [f"{', '.join(parts)}; {place}", heights]


def _attention(diagnostics: Diagnostics) -> Iterator[tuple[int, str]]:
    """Yield what needs attention, with its harm."""
    first = _first(diagnostics)
    for (kind, code), count in diagnostics.counts().items():
        known = codes().get(code)
        if known is not None and known.harm is not None:
            yield known.harm, f"{code}: {example(*first[kind, code], count, _TEXT_MOST)}"


def _first(diagnostics: Diagnostics) -> dict[tuple[Kind, str], tuple[str, str]]:
    """Return message and element of the first finding of each kind and code."""
    first: dict[tuple[Kind, str], tuple[str, str]] = {}
    for item in diagnostics:
        first.setdefault((item.kind, item.code), (item.message, item.osm_id))
    return first


def kinds_of_findings(diagnostics: Diagnostics) -> list[str]:
    """Return a line for each kind of diagnostic: how often it was found, and the first one."""
    first = _first(diagnostics)
    order = sorted(
        diagnostics.counts().items(), key=lambda entry: (_KINDS.index(entry[0][0]), -entry[1], entry[0][1])
    )
    return [f"  {kind.value:<9}{n:>8,}  {code}: {example(*first[kind, code], n)}" for (kind, code), n in order]


def percent(share: float) -> str:
    """Return a share in per cent, never rounded up to 100 or down to 0."""
    if share in (0.0, 1.0):
        return f"{100 * share:.0f} %"
    return f"{min(max(100.0 * share, 0.1), 99.9):.1f} %"
