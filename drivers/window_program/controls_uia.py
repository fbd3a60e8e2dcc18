"""Controls of a Windows program, by UI Automation through pywinauto.

Every property is a question to the other program, which may have closed the control meanwhile (COMError).
pywinauto is loaded in COM's multithreaded mode, so that any thread of ours may ask.
"""

from collections.abc import Iterator
from typing import Any

from ...system.extras import not_installed
from .controls import Control, Found
from .windows import NoScreen, Window

ON = 1
"""ToggleState_On; 0 is off, 2 neither."""


class UiaControls:
    """Raises NoScreen where UI Automation cannot be had."""

    def __init__(self) -> None:
        try:
            from comtypes import COMError  # pyright: ignore[reportMissingImports]
            from pywinauto import (  # pyright: ignore[reportMissingImports]
                uia_defines,
                uia_element_info,
            )
        except ImportError as fault:
            raise NoScreen(
                f"controls cannot be found by name: {not_installed(fault, 'gui') or fault}"
            ) from fault
        self._gone: type[Exception] = COMError
        self._no_pattern: type[Exception] = uia_defines.NoPatternInterfaceError
        self._pattern = uia_defines.get_elem_interface
        self._element = uia_element_info.UIAElementInfo

    def find(self, window: Window, wanted: Control) -> list[Found]:
        # What is said here is searched for by the program itself: a window may have thousands of controls.
        searched = {"control_type": wanted.type, "title": wanted.name}
        if wanted.name and "*" in wanted.name:
            del searched["title"]
        said = {word: what for word, what in searched.items() if what}
        return list(self._visible(window, wanted, said))

    def all(self, window: Window) -> list[Found]:
        return list(self._visible(window, None, {}))

    def _visible(
        self, window: Window, wanted: Control | None, said: dict[str, str]
    ) -> Iterator[Found]:
        try:
            elements = self._element(window.id).descendants(**said)
        except KeyError:  # pywinauto has a table of types
            raise NoScreen(
                f"UI Automation knows no control of the type {said['control_type']}"
            ) from None
        except self._gone:
            return
        for element in elements:
            try:
                found = self._found(element, wanted)
            except self._gone:
                continue
            if found is not None:
                yield found

    def _found(self, element: Any, wanted: Control | None) -> Found | None:
        name, known_id = element.name or "", element.automation_id or ""
        if (wanted is None and not name and not known_id) or not element.visible:
            return None
        if wanted is not None and not wanted.fits(name, known_id):
            return None
        rect = element.rectangle
        width, height = rect.right - rect.left, rect.bottom - rect.top
        if width <= 0 or height <= 0:
            return None
        value = self._asked(element, "Value", "CurrentValue")
        return Found(
            name, known_id, element.control_type or "", (rect.left, rect.top, width, height),
            element.enabled, self._ticked(element), name if value is None else str(value),
        )  # fmt: skip

    def _ticked(self, element: Any) -> bool | None:
        state = self._asked(element, "Toggle", "CurrentToggleState")
        if state is not None:
            return {0: False, ON: True}.get(state)
        chosen = self._asked(element, "SelectionItem", "CurrentIsSelected")
        return None if chosen is None else bool(chosen)

    def _asked(self, element: Any, pattern: str, what: str) -> Any:
        """A property of a pattern; None for a control that does not have it."""
        try:
            return getattr(self._pattern(element.element, pattern), what)
        except self._no_pattern:
            return None
