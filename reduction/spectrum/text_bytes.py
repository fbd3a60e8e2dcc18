"""Bring the bytes of a text to one alphabet: UTF-8 or any other in which digits are ASCII."""

import codecs
import re

from .fault import Unreadable

MARKS = (
    (codecs.BOM_UTF8, ""),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
KINDS = (
    (b"PK\x03\x04", "a zip archive; unpack it"),
    (
        b"\xd0\xcf\x11\xe0",
        "a compound file, as of Shimadzu, JASCO or old Office; export it there as text or CSV",
    ),
    (b"WDF1", "a Renishaw .wdf file; save it in WiRE as .txt"),
    (b"\x0a\x0a\xfe\xfe", "a Bruker OPUS file; save it in OPUS as a data point table (.dpt)"),
    (b"PEPE", "a PerkinElmer .sp file; export it as ASCII"),
    (b"<!--TriVista-File", "a TriVista .tvf file; export it in VistaControl as ASCII"),
    (b"CPY", "an Origin project; export its worksheet as ASCII"),
    (b"IM", "a Hamamatsu picture of a streak camera; export a profile of it as text"),
    (b"PDS_VERSION_ID", "a file of the Planetary Data System; use its table as CSV"),
    (b"\x80\x02", "a Python pickle, which could run code; save the arrays with numpy.savez"),
    (b"\x80\x03", "a Python pickle, which could run code; save the arrays with numpy.savez"),
    (b"\x80\x04\x95", "a Python pickle, which could run code; save the arrays with numpy.savez"),
    (b"\x80\x05\x95", "a Python pickle, which could run code; save the arrays with numpy.savez"),
    (b"%PDF", "a PDF; look for the data beside it"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xd8\xff", "a picture"),
    (b"GIF8", "a picture"),
    (b"II*\0", "a picture"),
    (b"MM\0*", "a picture"),
    (b"BM", "a picture"),
    (b"BZh", "packed with bzip2; unpack it"),
    (b"\xfd7zXZ", "packed with xz; unpack it"),
    (b"7z\xbc\xaf", "a 7z archive; unpack it"),
    (b"Rar!", "a rar archive; unpack it"),
    (b"SQLite format", "a database; export its table as CSV"),
    (b"MATLAB ", "a MATLAB file of an unknown version; save it with -v7.3"),
    (b"SIMPLE  =", "a FITS file; save its table as CSV, as with TOPCAT"),
)
BEGINNING = 4096
CONTROL = re.compile(rb"[\x01-\x08\x0e-\x1f\x7f]")
TYPESET = (
    ("\N{MINUS SIGN}".encode(), b"-"),
    ("\N{NO-BREAK SPACE}".encode(), b" "),
    ("\N{NARROW NO-BREAK SPACE}".encode(), b" "),
    ("\N{RIGHT SINGLE QUOTATION MARK}".encode(), b"'"),
)


def text_bytes(raw: bytes) -> bytes:
    """The text without its byte order mark, lines ended by LF. Raises Unreadable for no text."""
    for mark, encoding in MARKS:
        if raw.startswith(mark):
            return _lines(_decoded(raw, encoding) if encoding else raw[len(mark) :])
    beginning = raw[:BEGINNING]
    if b"\0" in beginning:
        for at, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
            zeros, others = beginning[at::2].count(0), beginning[1 - at :: 2].count(0)
            if zeros > 0.9 * (len(beginning) // 2) > 9 * others:
                return _lines(_decoded(raw, encoding))
    kind = kind_of(raw)
    if kind:
        raise Unreadable(
            f"this is {kind}. A spectrum is text, as every program exports it, or one of the formats of "
            "the manual"
        )
    return _lines(raw)


def kind_of(raw: bytes) -> str:
    """What a file that is no text is, as the end of a sentence; empty for text."""
    for magic, kind in KINDS:
        if raw.startswith(magic) and (len(magic) > 2 or b"\0" in raw[:BEGINNING]):
            return kind
    beginning = raw[:BEGINNING]
    filled = beginning.replace(b"\0", b"")  # AvaSoft 7 fills a name with zero bytes
    text = b"\0" not in beginning or (b"\n" in filled and not CONTROL.search(filled))
    return "" if text else "not text"


def shown(line: bytes) -> str:
    """A line as a person reads it."""
    for encoding in ("utf-8", "gb2312"):  # in the second, letters of cp1252 would come in pairs
        try:
            return line.decode(encoding).strip()
        except UnicodeDecodeError:
            continue
    return line.decode("cp1252", "replace").replace("\N{NO-BREAK SPACE}", " ").strip()


def _decoded(raw: bytes, encoding: str) -> bytes:
    try:
        return raw.decode(encoding).encode()
    except UnicodeDecodeError:
        raise Unreadable(
            f"the text is {encoding.upper()}, but broken: was it cut off or transferred wrongly?"
        ) from None


def _lines(text: bytes) -> bytes:
    if b"\0" in text:
        text = text.replace(b"\0", b"")
    if not text.isascii():
        for mark, plain in TYPESET:
            text = text.replace(mark, plain)
    if b"\r" in text and b"\n" not in text:
        return text.replace(b"\r", b"\n")
    return text
