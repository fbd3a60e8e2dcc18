"""How quickly something goes and how long it will still take, in words."""


def rate_text(rate: float) -> str:
    """So many per second, or per minute or hour if they are slow."""
    if rate >= 0.5:
        return f"{rate:.1f}/s"
    return f"{rate * 60:.1f}/min" if rate * 60 >= 0.5 else f"{rate * 3600:.1f}/h"


def duration_text(seconds: float | None) -> str:
    """`1:02:03`, `4:05`, or a dash."""
    if seconds is None:
        return "-"
    whole = round(seconds)
    hours, minutes, rest = whole // 3600, whole // 60 % 60, whole % 60
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
