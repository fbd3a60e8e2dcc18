"""Those parts of pywinauto 0.6.9 that the driver calls, over controls that a test tells of.

As there: a window that is gone raises COMError when it is asked for, a control that is gone when its
state is; conditions are keywords of a closed list; a type outside its table is a KeyError; a pattern
that a control lacks is NoPatternInterfaceError; a check box that is neither says 2.
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType, SimpleNamespace
from typing import Any

Told = dict[str, Any]
TYPES = {"Button", "CheckBox", "Edit", "RadioButton", "Text", "Window"}
CONDITIONS = {"process", "class_name", "title", "control_type", "content_only"}


class COMError(Exception):
    """comtypes.COMError is no OSError."""


class NoPatternInterfaceError(Exception):
    pass


def get_elem_interface(element: Told, pattern: str) -> SimpleNamespace:
    has = {"Value": "value", "Toggle": "ticked", "SelectionItem": "chosen"}[pattern]
    if element.get(has) is None:
        raise NoPatternInterfaceError
    if pattern == "Toggle":
        state = element["ticked"]
        return SimpleNamespace(CurrentToggleState=2 if state == "neither" else int(state))
    return SimpleNamespace(CurrentValue=element[has], CurrentIsSelected=element[has])


def element_info(windows: Callable[[], dict[int, list[Told]]]) -> type:
    """UIAElementInfo over what `windows` tells now: handle -> controls."""

    @dataclass
    class UIAElementInfo:
        handle: int | None = None
        element: Any = None

        def __post_init__(self) -> None:
            if self.handle is not None and self.handle not in windows():
                raise COMError(-2147220991, "An event was unable to invoke any subscribers")

        def descendants(self, **said: Any) -> list[Any]:
            assert set(said) <= CONDITIONS
            if said.get("control_type") not in (None, *TYPES):
                raise KeyError(said["control_type"])
            there = windows().get(self.handle or 0, [])
            return [UIAElementInfo(element=one) for one in there if _fits(one, said)]

        @property
        def name(self) -> str:
            return self.element["name"]

        @property
        def automation_id(self) -> str | None:
            return self.element["id"]

        @property
        def control_type(self) -> str:
            return self.element["type"]

        @property
        def visible(self) -> bool:
            return not self.element.get("offscreen", False)

        @property
        def enabled(self) -> bool:
            if self.element.get("gone"):
                raise COMError(-2147220991, "")
            return self.element.get("enabled", True)

        @property
        def rectangle(self) -> SimpleNamespace:
            x, y, width, height = self.element["box"]
            return SimpleNamespace(left=x, top=y, right=x + width, bottom=y + height)

    return UIAElementInfo


def _fits(one: Told, said: dict[str, Any]) -> bool:
    return said.get("title") in (None, one["name"]) and said.get("control_type") in (
        None,
        one["type"],
    )


def install(monkeypatch: Any, windows: Callable[[], dict[int, list[Told]]]) -> None:
    """As if comtypes and pywinauto were installed."""
    modules = {name: ModuleType(name) for name in ("comtypes", "pywinauto")}
    parts = {"uia_defines": ModuleType("uia_defines"), "uia_element_info": ModuleType("x")}
    vars(modules["comtypes"])["COMError"] = COMError
    vars(parts["uia_defines"]).update(
        get_elem_interface=get_elem_interface, NoPatternInterfaceError=NoPatternInterfaceError
    )
    vars(parts["uia_element_info"])["UIAElementInfo"] = element_info(windows)
    vars(modules["pywinauto"]).update(parts)
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    for name, module in parts.items():
        monkeypatch.setitem(sys.modules, f"pywinauto.{name}", module)
