"""Text files of a user: read, or refused in a line."""

import re
import stat
from pathlib import Path

LARGEST = 100_000_000  # most bytes that are read, unless less is allowed

UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # marks at the beginning of a text in UTF-16


class TextFileError(ValueError):
    """A file that is no text, or cannot be read."""

    def __init__(self, message: str, line: int | None = None) -> None:
        self.message, self.line = message, line
        super().__init__(message if line is None else f"line {line}: {message}")


def read_text(path: Path, limit: int = LARGEST) -> str:
    """Read a text in UTF-8, with or without its mark.

    Parameters
    ----------
    path
        A file.
    limit
        Bytes that it may have.

    Raises
    ------
    TextFileError
        If there is no such file, it is no file, cannot be read, is too large or is no such text.
    """
    return decoded(read_bytes(path, limit))


def read_table_text(path: Path, limit: int = LARGEST) -> tuple[str, str]:
    """Read a text of a spreadsheet or an old program: UTF-8, UTF-16 with its mark, or Windows-1252.

    Returns
    -------
    The text, and its encoding where it is not UTF-8.

    Raises
    ------
    TextFileError
        As `read_text`.
    """
    data = read_bytes(path, limit)
    for encoding in ("UTF-16",) if data.startswith(UTF_16) else ("UTF-8", "Windows-1252"):
        try:
            text = data.decode({"UTF-8": "utf-8-sig"}.get(encoding, encoding))
        except UnicodeError:
            continue
        if "\0" not in text:
            return text, encoding.removeprefix("UTF-8")
    return decoded(data), ""  # which refuses it


def read_bytes(path: Path, limit: int = LARGEST) -> bytes:
    """Read a file; neither a pipe nor a device is waited for, see `read_text`.

    Of a file that states no bytes, as those of ``/proc`` do, nothing is read: some never end.
    """
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise TextFileError("is a folder; must be a file")
        if not stat.S_ISREG(status.st_mode):
            raise TextFileError("must be a file")
        if status.st_size > limit:
            raise TextFileError(f"has {_bytes(status.st_size)}; allowed are {_bytes(limit)}")
        with path.open("rb") as file:
            return file.read(status.st_size)
    except TextFileError:
        raise
    except (OSError, ValueError) as error:  # such as a NUL in its name
        message = getattr(error, "strerror", None) or error
        raise TextFileError(f"cannot be read: {message}") from None


def decoded(data: bytes) -> str:
    r"""Return the text of bytes in UTF-8, without its mark.

    Examples
    --------
    >>> decoded("größe".encode("utf-8-sig"))
    'größe'
    >>> try:
    ...     decoded("a\ngröße".encode("latin-1"))
    ... except TextFileError as error:
    ...     error.line, error.message
    (2, 'must be text in UTF-8; the byte 0xf6 is ö in Latin-1')
    """
    if data.startswith(UTF_16):
        raise TextFileError("must be text in UTF-8; it is in UTF-16")
    if b"\0" in data:
        line = data[: data.index(b"\0")].count(b"\n") + 1
        raise TextFileError("must be text in UTF-8; it has a byte 0x00, as of a binary file", line)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line, byte = data[: error.start].count(b"\n") + 1, data[error.start]
        letter = bytes([byte]).decode("latin-1")
        reading = f"is {letter} in Latin-1" if letter.isprintable() else "is not text"
        message = f"must be text in UTF-8; the byte 0x{byte:02x} {reading}"
        raise TextFileError(message, line) from None


def included(path: Path, line: int, name: str, folder: Path) -> Path:
    """Return a file that a line includes, which must be in the folder of the first file."""
    places = [(base / name).resolve() for base in (folder, path.parent)]
    for place in places:
        if place.is_relative_to(folder.resolve()) and place.is_file() and place != path.resolve():
            return place
    raise ValueError(f"{path}:{line}: {name!r} is not a file in {folder}, where it must be")


def lines_of(text: str) -> list[str]:
    r"""Return the lines of a text, whichever system wrote it.

    Examples
    --------
    >>> lines_of("a\r\nb\rc\n")
    ['a', 'b', 'c', '']
    """
    return re.split("\r\n|\r|\n", text)


def _bytes(count: int) -> str:
    return f"{count / 1e6:.3g} MB"


def one_line(text: str) -> str:
    """Return a text with all that would break its line written as escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
