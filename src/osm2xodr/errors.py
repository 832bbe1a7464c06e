"""What can go wrong, as exceptions that say it in one sentence."""

from __future__ import annotations


class Osm2xodrError(Exception):
    """Something cannot be done; the message names the cause and the remedy in one sentence."""


class OptionError(Osm2xodrError, ValueError):
    """An option has a value that cannot be, or contradicts another one.

    Parameters
    ----------
    message
        One sentence that begins with the names of the options.
    options
        These names.
    """

    def __init__(self, message: str, *options: str) -> None:
        super().__init__(message)
        self.options = options


class InputError(Osm2xodrError):
    """A file that was given cannot be read or is not what it should be."""


class SwappedAxesError(InputError):
    """A part of a map that is asked for lies beside it, and in it with longitude and latitude swapped."""


class EmptyAreaError(InputError):
    """There is nothing to drive on in the area: for one of many areas that may be as it should be."""


class CoverageError(Osm2xodrError):
    """The elevation model does not reach where the roads are."""


class OutputError(Osm2xodrError):
    """The result cannot be written."""
