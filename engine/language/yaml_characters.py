"""Characters that word processors and other keyboards put in place of those YAML needs."""

import unicodedata

INSTEAD = {
    "\u00a0": "a space", "\u202f": "a space", "\u2009": "a space", "\u3000": "a space",
    "“": '"', "”": '"', "„": '"', "«": '"', "»": '"', "‘": "'", "’": "'", "‚": "'",
    "：": "`: `", "，": "`, `", "；": ";", "（": "(", "）": ")", "［": "[", "］": "]",
    "｛": "{", "｝": "}", "＝": "=", "＃": "#", "－": "-", "＊": "*", "＋": "+",
    "•": "-", "–": "-", "—": "-", "−": "-", "×": "*", "·": "*", "÷": "/", "≤": "<=", "≥": ">=", "≠": "!=",
}  # fmt: skip
NAMES = {
    "\u00a0": "a non-breaking space", "\u202f": "a narrow non-breaking space",
    "\u3000": "a full-width space", "\u200b": "a space of no width", "\ufeff": "a byte order mark",
    "\u00ad": "a soft hyphen", "：": "a full-width colon",
}  # fmt: skip
LOOKALIKE = {
    **dict(zip("аеорсухіјѕԁһԛԝ", "aeopcyxijsdhqw", strict=True)),
    **dict(zip("АВЕКМНОРСТХІЈЅ", "ABEKMHOPCTXIJS", strict=True)),
    **dict(zip("οΟΑΒΕΗΙΚΜΝΡΤΥΧΖ", "oOABEHIKMNPTYXZ", strict=True)),
}
"""Cyrillic and Greek letters that no eye tells from Latin ones."""
INVISIBLE = {"Cf", "Cc", "Zs", "Zl", "Zp"}


def named(character: str) -> str:
    """`a full-width colon (U+FF1A)`: a name for a character that looks like another."""
    code = f"U+{ord(character):04X}"
    if character in LOOKALIKE:
        return f"{character} ({unicodedata.name(character).split()[0].title()}, {code})"
    if name := NAMES.get(character):
        return f"{name} ({code})"
    if unicodedata.category(character) in INVISIBLE:
        return f"an invisible character ({code})"
    return f"{character} ({code})"


def odd(character: str) -> bool:
    """True for an invisible character or one used in place of another."""
    if character.isascii():
        return False
    return _instead(character) != "" or unicodedata.category(character) in INVISIBLE


def _instead(character: str) -> str:
    """What to write instead: a sign that YAML needs, a Latin letter, a digit of the usual width."""
    if found := INSTEAD.get(character) or LOOKALIKE.get(character):
        return found
    usual = unicodedata.normalize("NFKC", character)
    return usual if usual.isascii() and "FULLWIDTH" in unicodedata.name(character, "") else ""


def odd_characters(text: str) -> str:
    """A hint about the first character of a text that is not what it looks like; or nothing."""
    found = next((character for character in text if odd(character)), None)
    if found is None:
        return ""
    instead = _instead(found)
    what = f"write {instead} instead" if instead else "remove it"
    return f"it holds {named(found)}; {what}"
