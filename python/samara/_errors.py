"""What Samara raises. Each is one sentence that names the thing, its value, and what was expected.

They are Python's own kinds as well: who knows nothing of Samara catches ``ValueError``, ``OSError``, ``RuntimeError``.
"""


class Error(Exception):
    """Base of the family."""


class ArgumentError(Error, ValueError):
    """The call was wrong: an unknown name, a shape that does not match, NaN."""


class InputError(Error, OSError, ValueError):
    """A file, or the text of one, is missing, malformed, or says something impossible."""


class OutsideBoxError(Error, ValueError):
    """A point outside the box of a codebook was asked for."""


class NoResultError(Error, RuntimeError):
    """Work ended before there was any result to give."""


class MissingPackageError(Error, ImportError):
    """An optional package is not installed."""
