"""Parse the bytes of a two-column text into numbers, at a few nanoseconds per byte.

A field of up to 15 digits is read exactly as `float` would read it (its digits and its power of
ten are both exact, so one division rounds once); a longer one to the last bit but one. An unusual
line (text, nan, a huge exponent) is left to the caller.
"""

import numpy as np

from .kernel import inner_kernel, kernel

MINUS, PLUS, POINT, ZERO, NINE = (ord(c) for c in "-+.09")
LINE_FEED, RETURN, SPACE, TAB, COMMA, SEMICOLON = (ord(c) for c in "\n\r \t,;")
EXPONENTS = tuple(ord(c) for c in "eEdD")  # Fortran writes 1.0D+02
EXACT_POWERS = np.array([10.0**n for n in range(23)])  # higher ones are not exact in a double
MAX_DIGITS = 18  # what fits into an int64
TEN, MOST_PLAIN = np.uint8(10), np.uint64(17)  # digits of a number that is read the quick way
LINE = 64  # more characters than any line of two such numbers


@inner_kernel
def many_digits(text, at, end):
    """As many digits as an int64 holds, of more that stand there, and their power of ten."""
    digits, kept, power = np.int64(0), 0, 0
    after_point = False
    while at < end:
        c = text[at]
        if c == POINT:
            after_point = True
        elif kept < MAX_DIGITS:
            digits = digits * 10 + (c - ZERO)
            kept += digits > 0
            power -= after_point
        else:
            power += not after_point
        at += 1
    return digits, power


@kernel
def number(text, at):
    """The number that begins at `at`: its value, where it ends, and whether it was understood."""
    end = len(text)
    negative = False
    if at < end and (text[at] == MINUS or text[at] == PLUS):
        negative = text[at] == MINUS
        at += 1
    digits, power, begin = np.int64(0), 0, at
    while at < end and ZERO <= text[at] <= NINE:
        digits = digits * 10 + (text[at] - ZERO)
        at += 1
    n_seen = at - begin
    if at < end and text[at] == POINT:
        at += 1
        point = at
        while at < end and ZERO <= text[at] <= NINE:
            digits = digits * 10 + (text[at] - ZERO)
            at += 1
        power = point - at
        n_seen -= power
    if n_seen == 0:
        return 0.0, at, False
    if n_seen > MAX_DIGITS:
        digits, power = many_digits(text, begin, at)
    if at < end and text[at] in EXPONENTS:
        at += 1
        down = at < end and text[at] == MINUS
        if at < end and (text[at] == MINUS or text[at] == PLUS):
            at += 1
        exponent, begin = 0, at
        while at < end and ZERO <= text[at] <= NINE and at - begin < 4:
            exponent = exponent * 10 + (text[at] - ZERO)
            at += 1
        if at == begin:
            return 0.0, at, False
        power += -exponent if down else exponent
    if power < -22 or power > 22:
        return 0.0, at, False
    value = digits / EXACT_POWERS[-power] if power < 0 else digits * EXACT_POWERS[power]
    return (-value if negative else value), at, True


@inner_kernel
def skip_blanks(text, at):
    while at < len(text) and (text[at] == SPACE or text[at] == TAB or text[at] == RETURN):
        at += 1
    return at


@kernel
def plain_pairs(text, at, first, second, n):
    """As `pairs`, of lines that are digits, one mark and digits: every other line is odd, and the last few.

    Places are unsigned, and it is one loop: code that may count places from the end, or that calls for
    each number, takes six times as long.
    """
    one, at = np.uint64(1), np.uint64(at)
    stop = np.uint64(max(len(text) - LINE, 0))
    x, negative = 0.0, False
    while at < stop:
        line = at
        for column in range(2):
            begin, power = at, np.uint64(0)
            end = at + MOST_PLAIN
            digits, c = np.int64(0), np.uint8(text[at] - ZERO)
            while c < TEN and at <= end:
                digits = digits * 10 + np.int64(c)
                at += one
                c = np.uint8(text[at] - ZERO)
            n_seen = at - begin
            if text[at] == POINT:
                at += one
                point, c = at, np.uint8(text[at] - ZERO)
                while c < TEN and at <= end:
                    digits = digits * 10 + np.int64(c)
                    at += one
                    c = np.uint8(text[at] - ZERO)
                power = at - point
                n_seen += power
            if n_seen == np.uint64(0) or n_seen > MOST_PLAIN:
                return np.int64(line), n
            value = digits / EXACT_POWERS[power]
            mark = text[at]
            if column == 0:
                if mark != COMMA and mark != TAB and mark != SEMICOLON:
                    return np.int64(line), n
                at += one
                x, negative = value, text[at] == MINUS
                if negative:
                    at += one
                continue
            if mark == RETURN:
                at += one
                mark = text[at]
            if mark != LINE_FEED:
                return np.int64(line), n
            at += one
            first[n], second[n] = x, -value if negative else value
            n += 1
    return np.int64(at), n


@kernel
def pairs(text, at, first, second, n):
    """Read lines of two numbers from `at` into first[n:], second[n:] until one is odd.

    text: uint8, shape (m,). Returns where the odd line begins (m if there was none) and how many
    rows are filled. Empty lines are skipped; a line with a third column is odd.
    """
    end = len(text)
    while at < end:
        begin = at
        at = skip_blanks(text, at)
        if at < end and text[at] == LINE_FEED:
            at += 1
            continue
        if at == end:
            break
        x, at, understood = number(text, at)
        if not understood:
            return begin, n
        after = at
        at = skip_blanks(text, at)
        if at < end and (text[at] == COMMA or text[at] == SEMICOLON):
            at = skip_blanks(text, at + 1)
        elif at == after:
            return begin, n
        y, at, understood = number(text, at)
        if not understood:
            return begin, n
        at = skip_blanks(text, at)
        if at < end and (text[at] == COMMA or text[at] == SEMICOLON):
            at = skip_blanks(text, at + 1)
        if at < end and text[at] != LINE_FEED:
            return begin, n
        at += 1
        first[n] = x
        second[n] = y
        n += 1
    return end, n
