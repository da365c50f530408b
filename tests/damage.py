"""Ways in which files get damaged: by kills, disks, editors, spreadsheets and malice."""

import codecs
import json
import re


def truncate(content, generator):
    return content[: generator.randrange(len(content) + 1)]


def flip_bytes(content, generator):
    damaged = bytearray(content)
    for _ in range(generator.choice((1, 3, 30))):
        damaged[generator.randrange(len(damaged))] = generator.randrange(256)
    return bytes(damaged)


def insert_garbage(content, generator):
    at = generator.randrange(len(content) + 1)
    garbage = generator.choice(
        (b"\0" * 512, b"\n\n\n", b",,,,", b'"', b"\xff\xfe", "é".encode("latin-1"), b"1,2,3\n", b"nan" * 9, b"[" * 3000)
    )
    return content[:at] + garbage + content[at:]


def _lines(content):
    return content.splitlines(keepends=True)


def drop_column(content, generator):
    rows = [line.split(b",") for line in content.splitlines()]
    at = generator.randrange(max(1, len(rows[0]) if rows else 1))
    return b"\n".join(b",".join(row[:at] + row[at + 1 :]) for row in rows) + b"\n"


def drop_header(content, generator):
    return b"".join(_lines(content)[1:])


def repeat_lines(content, generator):
    lines = _lines(content)
    at = generator.randrange(len(lines))
    return b"".join(lines[: at + 1] + lines[max(0, at - generator.randrange(3)) :])


def shuffle_lines(content, generator):
    head, *rest = _lines(content)
    generator.shuffle(rest)
    return b"".join([head, *rest])


ABSURD = (b"1e300", b"-1e300", b"inf", b"nan", b"-9999", b"abc", b"", b"0x10", b"1_0", b"true", b"9" * 5000, b"5e-324")


ABSURD_NUMBERS = (b"-1", b"0", b"2" + b"0" * 18, b"9223372036854775808", b"1e400", b"NaN", b"[1]", b"{}")


def absurd_value(content, generator):
    """A cell of a CSV, or a number of any text, becomes absurd."""
    rows = [line.split(b",") for line in content.splitlines()]
    row = generator.choice(rows[1:] or rows)
    row[generator.randrange(len(row))] = generator.choice(ABSURD)
    return b"\n".join(map(b",".join, rows)) + b"\n"


def absurd_number(content, generator):
    """One of the numbers of a JSON or TOML file becomes absurd."""
    numbers = list(re.finditer(rb"(?<![\w.+-])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])", content))
    if not numbers:
        return content
    found = generator.choice(numbers)
    new = generator.choice(
        (*ABSURD, b"-1", b"0", b"2" + b"0" * 18, b"9223372036854775808", b"1e400", b"NaN", b"[1]", b"{}")
    )
    return content[: found.start()] + new + content[found.end() :]


def other_encoding(content, generator):
    text = content.decode("latin-1")
    return generator.choice(
        (
            text.encode("utf-16"),
            codecs.BOM_UTF8 + content,
            content.replace(b"\n", b"\r\n"),
            text.encode("utf-32"),
            content.replace(b"\n", b"\r"),
            content.replace(b",", b";"),
        )
    )


def empty(content, generator):
    return generator.choice((b"", b"\n", b"   ", b"null", b"[]", b'{"seed": []}', b"[" * 5000, b"a." * 3000 + b"a = 1"))


def other_types(content, generator):
    """Values of a JSON table become of another type, anywhere in it."""
    try:
        body = json.loads(content)
    except (ValueError, RecursionError):
        return content
    for _ in range(3):
        node = body
        while isinstance(node, dict) and node:
            key = generator.choice(sorted(node))
            if isinstance(node[key], dict) and generator.random() < 0.6:
                node = node[key]
                continue
            node[key] = generator.choice((None, [], {}, "x", -1, 1e300, True, {"a": [1]}, "<b>", 10**400))
            break
    return json.dumps(body).encode()


def drop_key(content, generator):
    """A key of a JSON table goes, or a line of any other text."""
    try:
        body = json.loads(content)
        body.pop(generator.choice(sorted(body)))
        return json.dumps(body).encode()
    except (ValueError, RecursionError, AttributeError, IndexError, TypeError):
        lines = _lines(content)
        lines.pop(generator.randrange(len(lines)))
        return b"".join(lines)


ANY = (truncate, flip_bytes, insert_garbage, repeat_lines, shuffle_lines, other_encoding, empty)
OF_TABLES = (*ANY, drop_column, drop_header, absurd_value)
OF_TEXTS = (*ANY, absurd_number, other_types, drop_key)


def damaged(content, generator, kinds):
    """One or two damages of these kinds."""
    for kind in generator.sample(kinds, generator.choice((1, 1, 2))):
        content = kind(content, generator) if content.strip() else content
    return content
