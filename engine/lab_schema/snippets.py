"""Sample steps for editors that support `defaultSnippets`; validators ignore them."""

from typing import Any

# An editor reads `$` as a placeholder, so the one that opens an expression is escaped.
SNIPPETS: list[dict[str, Any]] = [
    {
        "label": "foreach over a grid",
        "description": "The same steps at every point of a grid, each with one row in data.csv.",
        "body": {
            "foreach": {
                "point": "\\${{ grid(x=span(0, ${1:4}, ${2:0.2}), y=span(0, ${3:10}, ${2:0.2})) }}"
            },
            "key": "\\${{ point.ix }},\\${{ point.iy }}",
            "steps": [{"do": "${4:role.action}"}],
            "collect": {"x": "\\${{ point.x }}", "y": "\\${{ point.y }}"},
        },
    },
    {
        "label": "do with retry and fallback",
        "description": "An action that is retried; if it still fails, a person is asked.",
        "body": {
            "do": "${1:role.action}",
            "retry": {"attempts": 3, "wait": "${2:1 s}"},
            "fallback": [
                {"ask": "${3:It failed. What now?}", "choices": ["repeat", "skip", "stop"]}
            ],
        },
    },
    {
        "label": "parallel set",
        "description": "Actions of different devices that start together.",
        "body": {"parallel": [{"do": "${1:role.action}"}, {"do": "${2:role.action}"}]},
    },
]
