"""Cards of Nastran bulk data in short (8), long (16, ``GRID*``) or free fields (commas)."""

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from pidpanel.text_files import TextFileError, included, lines_of, read_bytes

BULK = ["BEGIN", "BULK"]
# More than any card that is read has; lists of nodes have more
MOST_FIELDS, MOST_LISTED = 64, 1_000_000
BLANKS = 24 * [""]  # behind the fields of a card
# Nastran may leave out the E of an exponent: 1.5-3 is 0.0015
SHORT_EXPONENT = re.compile(r"(?<=[0-9.])([+-][0-9]+)$")
QUOTED = re.compile(r"\s*INCLUDE\s*(?:'([^']*)'|\"([^\"]*)\"|(\S+))", re.IGNORECASE)


class Card(NamedTuple):
    """A card: its file and line, its name, and its fields without the name."""

    path: Path
    line: int
    name: str
    fields: list[str]

    @property
    def place(self) -> str:
        """File and line."""
        return f"{self.path}:{self.line}"


def read_cards(
    path: Path, faults: list[str], limits: Mapping[str, int], parents: tuple[Path, ...] = ()
) -> Iterator[Card]:
    """Yield the cards of a deck and of the files that it includes; add the faults of other lines.

    Parameters
    ----------
    limits
        Largest numbers of fields of the cards that are needed whole, by name.
    parents
        Files that include this one; all must be in the folder of the first.
    """
    parents = (*parents, path)
    lines = _lines(path)
    control = next((k for k, text in enumerate(lines) if text.upper().split() == BULK), 0)
    card: Card | None = None
    end = 0  # last line of a file name
    for number, text in enumerate(lines, 1):
        words = text.upper().split()
        if not words or number <= end or (number <= control and words[0] != "INCLUDE"):
            continue
        if words[0] == "ENDDATA" or words == ["END", "BULK"]:
            break
        if words == BULK:
            continue
        head, fields, surplus = _fields(text)
        name = (head.upper().rstrip("*").split() or [""])[0]
        is_continuation = name in ("", "+") or head.startswith(("+", "*"))
        owner = card.name if card is not None and is_continuation else name
        if surplus and owner in limits:
            message = f"{owner}: '{surplus}' follows the eighth field of a line"
            faults.append(f"{path}:{number}: {message}; allowed is a mark of continuation")
        if is_continuation:
            if card is None:
                faults.append(f"{path}:{number}: a continuation without a card")
            elif len(card.fields) <= limits.get(owner, MOST_FIELDS):
                card.fields.extend(fields)
            elif owner in limits:
                faults.append(f"{path}:{number}: a card has more than {limits[owner]} fields")
                break
            continue
        if card is not None:
            yield card
            card = None
        if words[0].startswith("INCLUDE"):
            match = QUOTED.match("\n".join(lines[number - 1 : number + 9]))
            file = re.sub(r"\s*\n\s*", "", "".join(match.groups("")) if match else "")
            end = number + match[0].count("\n") if match else number
            child = included(path, number, file, parents[0].parent)
            if child in [parent.resolve() for parent in parents]:
                raise ValueError(f"{path}:{number}: {file} includes itself")
            yield from read_cards(child, faults, limits, parents)
            continue
        placing = re.match("BEGIN|=", words[0])
        card = Card(path, number, placing[0] if placing else name, fields)
    if card is not None:
        yield card


def case_control(path: Path) -> str:
    """Return the executive and case control in capitals; empty where the bulk data begin."""
    lines = [text.upper() for text in _lines(path)]
    return "\n".join(lines[: next((k for k, text in enumerate(lines) if text.split() == BULK), 0)])


def _lines(path: Path) -> list[str]:
    """Return the lines of a file without comments."""
    try:
        data = read_bytes(path)
    except TextFileError as error:
        raise ValueError(f"{path}: {error.message}") from None
    if b"\0" in data:
        line = data[: data.index(b"\0")].count(b"\n") + 1
        raise ValueError(f"{path}:{line}: must be text; it has a byte 0x00, as of a binary file")
    # comments may be in any encoding
    lines = [raw.split("$")[0].rstrip().expandtabs(8) for raw in lines_of(data.decode("latin-1"))]
    if next(filter(None, lines), "").startswith("*"):
        raise ValueError(f"{path}: must be Nastran bulk data; it begins like an input of Abaqus")
    return lines


def _fields(text: str) -> tuple[str, list[str], str]:
    """Return the name of a card, its fields, and what follows them but for a continuation mark."""
    if "," in text:
        # fields 2 to 9; the tenth marks a continuation
        head, *fields = (field.strip() for field in text.split(","))
        width = 4 if "*" in head else 8
        if re.fullmatch(r"[+*]([A-Za-z]\w*)?", fields[-1]):
            fields.pop()  # a mark of continuation wherever the line ends
        fields += [""] * (width - len(fields))  # what continues begins in the ninth field
        mark, *surplus = [*fields[width:], ""]
        if not re.fullmatch(r"([+*A-Za-z].*)?", mark):
            surplus = [mark, *surplus]
        return head, fields[:width], ", ".join(filter(None, surplus))
    head, body = text[:8].strip(), text[8:72]
    width = 16 if "*" in head else 8
    return head, [body[k : k + width].strip() for k in range(0, 64, width)], ""


def whole_number(text: str) -> int:
    """Return a number from 1; `ValueError` for what is none."""
    number = int(text) if re.fullmatch("[0-9]{1,18}", text) else 0
    if number < 1:
        raise ValueError(f"{text or 'a blank'} is not allowed; a number from 1 is needed")
    return number


def real_number(text: str) -> float:
    """Return a number as Nastran writes it, 0 for a blank; `ValueError` for what is none."""
    try:
        number = float(SHORT_EXPONENT.sub(r"e\1", text.upper().replace("D", "E"))) if text else 0.0
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{text} is not a number")
    return number


def numbers_of(fields: list[str]) -> list[int]:
    """Return the numbers of a list with THRU, BY and EXCEPT.

    Examples
    --------
    >>> numbers_of(["1", "THRU", "9", "BY", "2", "EXCEPT", "5", "", "20"])
    [1, 3, 7, 9, 20]
    """
    words = [field.upper() for field in fields if field]
    numbers: list[int] = []
    is_left_out, k = False, 0
    while k < len(words):
        if words[k] == "EXCEPT":
            is_left_out, k = True, k + 1
            continue
        first, step = whole_number(words[k]), 1
        last, k = first, k + 1
        if k + 1 < len(words) and words[k] == "THRU":
            last, k, is_left_out = whole_number(words[k + 1]), k + 2, False
            if k + 1 < len(words) and words[k] == "BY":
                step, k = whole_number(words[k + 1]), k + 2
            if last - first > MOST_LISTED * step:
                raise ValueError(f"{first} THRU {last} has too many numbers")
        if is_left_out and first in numbers:
            numbers.remove(first)
        elif not is_left_out or (numbers and first > numbers[-1]):
            is_left_out = False
            numbers.extend(range(first, last + 1, step))
    return numbers
