"""A desktop program that behaves like an analyser's: buttons, dialogs, a cache folder, slow files.

Run with any Python that has tkinter: `python analyser_program.py '{"folder": "/tmp/x"}'`. It says
`ready` on stdout, obeys lines on stdin (see `obey`), and ends when stdin does. What its laser
really did stands in `shots.log`. Options and what they mean are in `OPTIONS`.
"""

import json
import random
import sys
import threading
import time
import tkinter as tk
from pathlib import Path

from looks import COMMON_WORDS, LOOKS
from spectra import csv_text

OPTIONS = {
    "folder": ".",
    "title": "Profile Builder 3.1",
    "look": "grey",
    "scale": 1.0,
    "at": [60, 40],
    "without": [],  # buttons of the main window that are not there
    "measure_s": 0.5,  # from the click to the entry in the cache; it fires half way
    "channels": 2000,
    "write_s": 0.5,  # how long a CSV grows
    "dialog_s": 0.1,  # before a dialog opens
    "ticked": [],  # check boxes that are already ticked
    "steps": 2,  # 2: first the folder, then the boxes; 1: all in one dialog
    "busy": False,  # from the start and for ever
    "keep": False,  # the cache entry of an earlier shot is selected, not the newest
    "exports": "selected",  # or "list": every entry is written, _1.csv the oldest
    "stray": "",  # a path that somebody else writes into the export folder when an export begins
    "late_s": 0.0,  # from the end of the dialogs to the first byte
    "says": "Ready",  # what the status bar says while nothing is done
    "sync_asks": False,  # synchronising opens a window that asks for a confirmation
    "forgets": False,  # boxes are empty whenever their dialog opens
    "delete_breaks": False,  # Delete works while it exports, and breaks the export off
}


class Program:
    """The main window and everything that it opens."""

    def __init__(self, options):
        self.options = {**OPTIONS, **options}
        self.look = LOOKS[self.options["look"]]
        self.words = {**COMMON_WORDS, **self.look["words"]}
        self.scale = float(self.options["scale"])
        folder = Path(self.options["folder"])
        self.folder, self.cache, self.exports = folder, folder / "cache", folder / "exports"
        for path in (self.cache, self.exports):
            path.mkdir(parents=True, exist_ok=True)
        self.entries = sorted(entry.name for entry in self.cache.iterdir())
        self.ticked = {
            name: name in self.options["ticked"] for name in ("separate_spectrum", "new_folder")
        }
        self.hang_after_click_s = 0.0
        self.error_after_click = ""
        self.busy = False
        self.broken_off = False
        self.others = {}
        self.root = tk.Tk()
        self._main_window()

    def px(self, pixels):
        return max(1, round(pixels * self.scale))

    def font(self, size=14):
        return (self.look["font"], -self.px(size), self.look["weight"])

    # -- the main window ---------------------------------------------------------------------

    def _main_window(self):
        root, look = self.root, self.look
        root.title(self.options["title"])
        x, y = self.options["at"]
        root.geometry(f"{self.px(620)}x{self.px(340)}+{x}+{y}")
        root.configure(bg=look["back"])
        bar = tk.Frame(root, bg=look["back"])
        bar.pack(fill="x", padx=self.px(8), pady=self.px(8))
        self.buttons = {}
        acts = {
            "measure": self.measure,
            "export": self.export,
            "sync": self.sync,
            "delete": self.delete,
        }
        for name, act in acts.items():
            if name not in self.options["without"]:
                self.buttons[name] = self.button(bar, name, act)
                self.buttons[name].pack(side="left", padx=self.px(4))
        row = tk.Frame(root, bg=look["back"])
        row.pack(fill="x", padx=self.px(12))
        if "sample_name" not in self.options["without"]:
            self.label(row, "sample_name").pack(side="left")
        self.name = self.entry(row, "sample")
        self.name.pack(side="left", padx=self.px(8))
        self.state = self.label(root, "", self.options["says"], "status")
        self.state.pack(side="bottom", anchor="w", padx=self.px(12))
        body = tk.Frame(root, bg=look["back"])
        body.pack(fill="both", expand=True, padx=self.px(12), pady=self.px(8))
        self.list = tk.Listbox(
            body,
            font=self.font(12),
            width=18,
            bg=look["field"],
            fg=look["ink"],
            selectbackground="#8899bb",
            highlightthickness=0,
            exportselection=False,
        )
        self.list.pack(side="left", fill="y")
        self.plot = tk.Canvas(body, bg=look["field"], highlightthickness=0)
        self.plot.pack(side="left", fill="both", expand=True, padx=self.px(8))
        self.show_entries()
        if self.options["busy"]:
            self.set_busy(True, "Working...")

    def button(self, parent, name, act):
        look = self.look
        across, down = look["pad"]
        return tk.Button(
            parent, text=self.words[name], command=act, font=self.font(), bg=look["button"],
            fg=look["button_ink"], activebackground=look["field"], relief=look["relief"],
            disabledforeground=look["grey_ink"], bd=self.px(2), highlightthickness=0,
            padx=self.px(across), pady=self.px(down),
        )  # fmt: skip

    def label(self, parent, name, text=None, known_as=None):
        words = self.words[name] if text is None else text
        return tk.Label(
            parent,
            name=known_as,
            text=words,
            font=self.font(),
            bg=self.look["back"],
            fg=self.look["ink"],
        )

    def entry(self, parent, name=None):
        return tk.Entry(
            parent,
            name=name,
            font=self.font(),
            width=26,
            bg=self.look["field"],
            fg=self.look["ink"],
            insertbackground=self.look["ink"],
            bd=self.px(2),
        )

    def show_entries(self):
        self.list.delete(0, "end")
        for entry in self.entries:
            self.list.insert("end", entry)
        if self.entries:
            self.list.selection_set(0 if self.options["keep"] else "end")
            self.draw(self.selected())

    def selected(self):
        chosen = self.list.curselection()
        return self.entries[chosen[0]] if chosen else None

    def draw(self, entry):
        self.root.update_idletasks()
        self.plot.delete("all")
        width, height = self.plot.winfo_width(), self.plot.winfo_height()
        drawn = random.Random(entry)
        points = []
        for x in range(0, width, 3):
            points += [
                x,
                height - 4 - abs(drawn.gauss(0, 3)) - height * 0.8 * (drawn.random() ** 40),
            ]
        if len(points) >= 4:
            self.plot.create_line(*points, fill="#b03030")

    def say(self, text):
        self.state.configure(text=text)

    def set_busy(self, busy, text):
        self.busy = busy
        for name, button in self.buttons.items():
            stays = name == "delete" and self.options["delete_breaks"]
            button.configure(state="disabled" if busy and not stays else "normal")
        self.say(text if busy else self.options["says"])

    # -- what the buttons do -----------------------------------------------------------------

    def measure(self):
        if self.hang_after_click_s:
            seconds, self.hang_after_click_s = self.hang_after_click_s, 0.0
            time.sleep(seconds)
        if self.error_after_click:
            text, self.error_after_click = self.error_after_click, ""
            self.root.after(self.ms("dialog_s"), lambda: self.error(text))
            return
        self.set_busy(True, "Measuring...")
        half = int(500 * self.options["measure_s"])
        self.root.after(half, lambda: self.fire(half))

    def fire(self, rest_ms):
        with (self.folder / "shots.log").open("a") as log:
            log.write(f"{time.time():.3f}\n")
        self.root.after(rest_ms, self.measured)

    def measured(self):
        name = f"shot_{time.time_ns() // 1_000_000}"
        (self.cache / name).mkdir()
        (self.cache / name / "raw.dat").write_text("raw\n" * 50)
        self.entries.append(name)
        self.show_entries()
        self.set_busy(False, "")

    def sync(self):
        if self.options["sync_asks"]:
            self.root.after(self.ms("dialog_s"), self.ask_sync)
        else:
            self.synchronised()

    def ask_sync(self):
        box = self.dialog("Confirm")
        self.label(box, "", "Synchronise now?").pack(padx=self.px(20), pady=self.px(10))

        def yes(event=None):
            box.destroy()
            self.synchronised()

        self.button(box, "delete_yes", yes).pack(side="left", padx=self.px(20), pady=self.px(10))
        self.button(box, "delete_no", box.destroy).pack(side="left", padx=self.px(10))
        box.bind("<Return>", yes)

    def synchronised(self):
        with (self.folder / "synced.log").open("a") as log:
            log.write(f"{time.time():.3f}\n")
        self.say("Synchronised")

    def delete(self):
        if self.selected() is not None:
            self.root.after(self.ms("dialog_s"), self.ask_delete)

    def ask_delete(self):
        box = self.dialog("Confirm")
        self.label(box, "", f"Delete {self.selected()}?").pack(padx=self.px(20), pady=self.px(10))
        yes = self.button(box, "delete_yes", lambda: self.deleted(box))
        yes.pack(side="left", padx=self.px(20), pady=self.px(10))
        self.button(box, "delete_no", box.destroy).pack(side="left", padx=self.px(10))
        box.bind("<Return>", lambda event: self.deleted(box))
        box.focus_force()

    def deleted(self, box):
        entry = self.selected()
        box.destroy()
        self.broken_off = self.busy
        for file in (self.cache / entry).iterdir():
            file.unlink()
        (self.cache / entry).rmdir()
        self.entries.remove(entry)
        self.show_entries()

    # -- exporting ---------------------------------------------------------------------------

    def export(self):
        if self.selected() is None:
            self.root.after(
                self.ms("dialog_s"), lambda: self.error("There is no spectrum to export")
            )
            return
        self.root.after(
            self.ms("dialog_s"), self.ask_folder if self.options["steps"] == 2 else self.ask_all
        )

    def ask_folder(self):
        box = self.dialog("Export: folder")
        folder = self.folder_row(box)

        def chosen(event=None):
            path = folder.get()
            box.destroy()
            if not Path(path).is_dir():
                self.root.after(
                    self.ms("dialog_s"), lambda: self.error(f"There is no folder {path}")
                )
            else:
                self.root.after(self.ms("dialog_s"), lambda: self.ask_boxes(path))

        self.button(box, "folder_ok", chosen).pack(side="left", padx=self.px(20), pady=self.px(10))
        box.bind("<Return>", chosen)

    def ask_boxes(self, path):
        box = self.dialog("Export: what")
        self.boxes(box)
        self.finish_row(box, lambda: path)

    def ask_all(self):
        box = self.dialog("Export")
        folder = self.folder_row(box)
        self.boxes(box)
        self.finish_row(box, folder.get)

    def folder_row(self, box):
        row = tk.Frame(box, bg=self.look["back"])
        row.pack(padx=self.px(20), pady=self.px(10))
        self.label(row, "folder").pack(side="left")
        folder = self.entry(row, "path")
        folder.pack(side="left", padx=self.px(6))
        folder.focus_force()
        return folder

    def boxes(self, box):
        if self.options["forgets"]:
            self.ticked = dict.fromkeys(self.ticked, False)
        for name in self.ticked:
            self.check_box(box, name).pack(anchor="w", padx=self.px(20), pady=self.px(4))

    def check_box(self, parent, name):
        size = self.px(16)
        row = tk.Frame(parent, bg=self.look["back"])
        square = tk.Canvas(
            row,
            width=size,
            height=size,
            bg=self.look["field"],
            highlightthickness=1,
            highlightbackground=self.look["ink"],
        )
        square.pack(side="left", padx=self.px(6))
        text = self.label(row, name)
        text.pack(side="left")

        def show():
            square.delete("all")
            if self.ticked[name]:
                square.create_line(
                    size * 0.2,
                    size * 0.55,
                    size * 0.45,
                    size * 0.85,
                    size * 0.9,
                    size * 0.2,
                    width=self.px(2.5),
                    fill=self.look["ink"],
                )

        def toggle(event):
            self.ticked[name] = not self.ticked[name]
            show()

        for part in (square, text):
            part.bind("<Button-1>", toggle)
        show()
        return row

    def finish_row(self, box, path):
        def finish():
            folder = path()
            box.destroy()
            self.write(Path(folder))

        self.button(box, "export_finish", finish).pack(
            side="left", padx=self.px(20), pady=self.px(10)
        )
        self.button(box, "export_cancel", box.destroy).pack(side="left", padx=self.px(10))

    def write(self, folder):
        """The CSVs grow piece by piece; only the boxes' state says where and how many."""
        name = self.name.get() or "spectrum"
        into = folder / name if self.ticked["new_folder"] else folder
        self.set_busy(True, "Exporting...")
        self.broken_off = False
        if self.options["stray"]:
            self.stray(folder / self.options["stray"])
        channels = self.options["channels"]
        if self.options["exports"] == "list":
            texts = {f"{n}": csv_text(e, "1", channels) for n, e in enumerate(self.entries, 1)}
        elif self.ticked["separate_spectrum"]:
            texts = {n: csv_text(self.selected(), n, channels) for n in ("1", "2")}
        else:
            texts = {"all": csv_text(self.selected(), "all", channels)}
        texts = {into / f"{name}_{n}.csv": text for n, text in texts.items()}
        pieces = max(1, round(self.options["write_s"] / 0.05))
        self.root.after(self.ms("late_s"), lambda: self.grow(texts, pieces, 0))

    def stray(self, path):
        """Somebody else's spectrum."""
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(csv_text(path.name, "stray", self.options["channels"]))

    def grow(self, texts, pieces, done):
        if self.broken_off:
            self.set_busy(False, "")
            return
        for path, text in texts.items():
            path.parent.mkdir(exist_ok=True)
            start, stop = (len(text) * k // pieces for k in (done, done + 1))
            with path.open("a", newline="") as file:
                file.write(text[start:stop])
        if done + 1 < pieces:
            self.root.after(50, lambda: self.grow(texts, pieces, done + 1))
        else:
            self.set_busy(False, "")

    # -- dialogs and trouble -----------------------------------------------------------------

    def ms(self, option):
        return int(1000 * self.options[option])

    def dialog(self, title):
        box = tk.Toplevel(self.root, bg=self.look["back"])
        box.title(title)
        box.transient(self.root)
        x, y = self.root.winfo_rootx(), self.root.winfo_rooty()
        box.geometry(f"+{x + self.px(90)}+{y + self.px(110)}")
        box.bind("<Escape>", lambda event: box.destroy())
        box.wait_visibility()
        box.grab_set()
        return box

    def error(self, text):
        box = self.dialog("Error")
        tk.Label(box, text="⚠", font=self.font(30), bg=self.look["back"], fg="#c02020").pack(
            side="left", padx=self.px(12)
        )
        self.label(box, "", text).pack(padx=self.px(20), pady=self.px(14))
        self.button(box, "error_close", box.destroy).pack(pady=self.px(10))

    def cover(self, colour, text=""):
        """What a locked or blank screen shows."""
        sheet = tk.Toplevel(self.root, bg=colour)
        sheet.overrideredirect(True)
        sheet.title("Locked")
        sheet.geometry(f"{sheet.winfo_screenwidth()}x{sheet.winfo_screenheight()}+0+0")
        if text:
            tk.Label(sheet, text=text, font=("DejaVu Sans", -40), bg=colour, fg="white").pack(
                expand=True
            )
        self.others["cover"] = sheet

    def cover_button(self):
        """Another program's window over the buttons."""
        other = tk.Toplevel(self.root, bg="#303050")
        other.title("Clock")
        other.geometry(f"200x60+{self.root.winfo_rootx()}+{self.root.winfo_rooty()}")
        self.others["clock"] = other

    def ask_boxes_here(self):
        self.ask_boxes(str(self.exports))

    def set_busy_for_ever(self):
        self.set_busy(True, "Working...")

    def second_window(self):
        other = tk.Toplevel(self.root)
        other.title(self.options["title"] + " (2)")
        size = f"{self.root.winfo_width()}x{self.root.winfo_height()}"
        other.geometry(f"{size}+900+500")
        self.others["second"] = other

    def obey(self, line):
        """One command; `places`, `controls` and `state` tell what there is, the rest cause trouble."""
        word, _, rest = line.partition(" ")
        if word == "hang":
            time.sleep(float(rest))
        elif word == "hang_after_click":
            self.hang_after_click_s = float(rest)
        elif word == "error":
            self.error(rest)
        elif word == "error_after_click":
            self.error_after_click = rest
        elif word == "lock":
            self.cover("#204060", "Locked: enter your password")
        elif word == "blank":
            self.cover("#000000")
        elif word == "second":
            self.second_window()
        elif word == "cover_button":
            self.cover_button()
        elif word == "close":
            self.others.pop(rest).destroy()
        elif word == "state":
            word = "busy" if self.busy else "idle"
        elif word == "minimise":
            self.root.withdraw()
        elif word == "open":
            getattr(self, rest)()
        elif word == "set":
            name, value = rest.split(" ", 1)
            self.options[name] = json.loads(value)
        self.settle()
        told = {"places": self.places, "controls": self.controls}.get(word)
        print(f"done {json.dumps(told()) if told else word}", flush=True)

    def settle(self):
        """Until all is drawn: each question to the X server brings what it wants redrawn meanwhile."""
        for _ in range(6):
            self.root.update()
            self.root.winfo_pointerx()
            time.sleep(0.005)

    def places(self):
        """Name -> x, y, width, height on the screen of everything that bears one of our words."""
        found = {}
        by_words = {words: name for name, words in self.words.items()}

        def look(widget):
            if isinstance(widget, (tk.Button, tk.Label)) and widget.winfo_viewable():
                name = by_words.get(widget.cget("text"))
                if name:
                    part = widget.master if name in self.ticked else widget
                    found[name] = [
                        part.winfo_rootx(),
                        part.winfo_rooty(),
                        part.winfo_width(),
                        part.winfo_height(),
                    ]
                if widget.cget("text") == "⚠":
                    found["error"] = [
                        widget.winfo_rootx(),
                        widget.winfo_rooty(),
                        widget.winfo_width(),
                        widget.winfo_height(),
                    ]
            for child in widget.winfo_children():
                look(child)

        look(self.root)
        state = self.state
        found["state"] = [
            state.winfo_rootx(), state.winfo_rooty(), state.winfo_width(), state.winfo_height()
        ]  # fmt: skip
        return found

    def controls(self):
        """What UI Automation tells of such a program: a window's title -> its controls."""
        found = {}

        def look(widget, window):
            if isinstance(widget, tk.Toplevel):
                window = widget.title()
            kind = {tk.Button: "Button", tk.Label: "Text", tk.Entry: "Edit"}.get(type(widget))
            if kind and widget.winfo_viewable():
                text = widget.get() if kind == "Edit" else widget.cget("text")
                box = [
                    widget.winfo_rootx(), widget.winfo_rooty(),
                    widget.winfo_width(), widget.winfo_height(),
                ]  # fmt: skip
                ticked = None
                for name in self.ticked:
                    if text == self.words[name]:
                        kind, ticked = "CheckBox", self.ticked[name]
                found.setdefault(window, []).append({
                    "name": "" if kind == "Edit" else text, "id": widget.winfo_name(), "type": kind,
                    "box": box, "enabled": str(widget.cget("state")) != "disabled",
                    "value": text if kind == "Edit" else None, "ticked": ticked,
                })  # fmt: skip
            for child in widget.winfo_children():
                look(child, window)

        look(self.root, self.root.title())
        return found

    def run(self):
        lines = []
        threading.Thread(target=listen, args=[lines], daemon=True).start()

        def poll():
            while lines:
                line = lines.pop(0)
                if line is None:
                    self.root.destroy()
                    return
                self.obey(line)
            self.root.after(20, poll)

        self.settle()
        self.show_entries()
        self.settle()
        print("ready", flush=True)
        poll()
        self.root.mainloop()


def listen(lines):
    for line in sys.stdin:
        lines.append(line.strip())
    lines.append(None)


if __name__ == "__main__":
    Program(json.loads(sys.argv[1])).run()
