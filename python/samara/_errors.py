"""What Samara raises. Each is one sentence that names the thing, its value, and what was expected.

They are Python's own kinds as well: who knows nothing of Samara catches ``ValueError``, ``OSError``, ``RuntimeError``.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Optional

_QUOTED_OR_OPTION = re.compile(
    r'"[^"]*"'
    r"|(?<![\w/-])--(fresh|span|left-out-span|left-out|ahead|config|sidecar|coefficients|profiles|reference|model-library)(?![\w-])"
)
_OTHERS = {"fresh": "resume=False", "model-library": "the command has --model-library"}


def in_words_of_python(sentence: str) -> str:
    """Names arguments where a sentence of the library names options of the command. What stands in quotes is the user's."""

    def argument(found: re.Match[str]) -> str:
        option: Optional[str] = found[1]
        return found[0] if option is None else _OTHERS.get(option, option.replace("-", "_"))

    return _QUOTED_OR_OPTION.sub(argument, sentence)


class Error(Exception):
    """Base of the family."""


class ArgumentError(Error, ValueError):
    """The call was wrong: an unknown name, a shape that does not match, NaN."""


class UnknownNameError(ArgumentError, KeyError):
    """A name in brackets, as in ``result["C_D"]``, of what is not there."""

    def __str__(self) -> str:
        return Exception.__str__(self)  # that of a KeyError would be in quotes


class InputError(Error, OSError, ValueError):
    """A file, or the text of one, is missing, malformed, or says something impossible."""


class OutsideBoxError(Error, ValueError):
    """A point outside the box of a codebook was asked for."""


class NoResultError(Error, RuntimeError):
    """Work ended before there was any result to give."""


class MissingPackageError(Error, ImportError):
    """An optional package is not installed."""


@contextmanager
def writing() -> Iterator[None]:
    """What cannot be written is wrong of the file, where the library says it of an argument."""
    try:
        yield
    except ArgumentError as error:
        raise InputError(str(error)) from None
