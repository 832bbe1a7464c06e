"""What can go wrong with a conversion, as exceptions with one sentence for the user."""


class Osm2xodrError(Exception):
    """A conversion cannot be done; the message names the cause and the remedy in one sentence."""


class InputError(Osm2xodrError):
    """A file that was given cannot be read or is not what it should be."""


class EmptyAreaError(InputError):
    """There is nothing to drive on in the area: for one of many areas that may be as it should be."""


class CoverageError(Osm2xodrError):
    """The elevation model does not reach where the roads are."""


class OutputError(Osm2xodrError):
    """The result cannot be written."""
