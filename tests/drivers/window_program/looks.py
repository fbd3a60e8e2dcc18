"""How the test's analyser program may look: colours, letters, shapes, words; plain data."""

LOOKS = {
    "grey": {
        "font": "DejaVu Sans", "weight": "normal", "back": "#d9d9d9", "ink": "#101010",
        "button": "#e8e8e8", "button_ink": "#101010", "grey_ink": "#a8a8a8", "relief": "raised",
        "pad": (10, 5), "field": "#ffffff",
        "words": {"measure": "Measure", "export": "Export...", "delete": "Delete", "sync": "Sync"},
    },
    "dark": {
        "font": "Liberation Sans", "weight": "bold", "back": "#23272e", "ink": "#e6e6e6",
        "button": "#3a7bd5", "button_ink": "#ffffff", "grey_ink": "#5c8fd0", "relief": "flat",
        "pad": (14, 7), "field": "#12151a",
        "words": {"measure": "START TEST", "export": "EXPORT", "delete": "DELETE", "sync": "SYNC"},
    },
    "paper": {
        "font": "DejaVu Serif", "weight": "normal", "back": "#fbf7ee", "ink": "#3b2f20",
        "button": "#f0e4c8", "button_ink": "#5a2d0c", "grey_ink": "#d8c9a8", "relief": "groove",
        "pad": (8, 4), "field": "#fffdf7",
        "words": {
            "measure": "◉ Fire", "export": "⇪ Save as", "delete": "✖ Remove", "sync": "⟳ Refresh",
        },
    },
}  # fmt: skip

COMMON_WORDS = {
    "sample_name": "Sample name:",
    "folder": "Folder:",
    "separate_spectrum": "Separate spectra",
    "new_folder": "In a new folder",
    "export_finish": "Finish",
    "export_cancel": "Cancel",
    "folder_ok": "Choose",
    "error_close": "OK",
    "delete_yes": "Yes",
    "delete_no": "No",
}
