"""What Samara raises. Each is one sentence that names the thing, its value, and what was expected.

They are Python's own kinds as well: who knows nothing of Samara catches ``ValueError``, ``OSError``, ``RuntimeError``.
"""

import re
from typing import Optional

_OPTION = re.compile(
    r"(?<![\w/-])--(fresh|span|left-out-span|left-out|ahead|config|sidecar|coefficients|profiles|reference)(?![\w-])"
)


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


def in_words_of_python(error: Optional[BaseException]) -> None:
    """Names arguments where a sentence of the library names options of the command."""
    if isinstance(error, Error) and len(error.args) == 1:
        error.args = (_OPTION.sub(_argument, str(error)),)


def _argument(option: re.Match[str]) -> str:
    return "resume=False" if option[1] == "fresh" else option[1].replace("-", "_")
